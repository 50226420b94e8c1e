/* Positions along a ray in 32.56 fixed point: sample k's position is first + k * step by integer arithmetic, so it does not
 * depend on how a method came to sample k, nor on bricks or slots. 56 fraction bits keep the sum right to 2^-32
 * voxel after 2^24 steps. */
struct Fixed3 {
    ivec3 cell;
    uvec3 fraction, tail; /* 2^-32, 2^-64; the last 8 bits are 0 along a ray */
};

/* The same in 8.56 fixed point, for small steps within 256 voxels of a given place. */
struct Near3 {
    uvec3 high, low; /* 2^-24, 2^-56 */
};

Fixed3 fixed_from(dvec3 p)
{
    const dvec3 two32 = dvec3(4294967296.0LF), most = dvec3(4294967295.0LF);
    dvec3 whole = floor(p);
    dvec3 scaled = (p - whole) * two32;
    dvec3 high = min(floor(scaled), most); /* p just below an integer: p - whole rounds to 1 */
    dvec3 low = clamp(floor((scaled - high) * two32), dvec3(0.0LF), most);
    return Fixed3(ivec3(whole), uvec3(high), uvec3(low) & 0xffffff00u);
}

Fixed3 fixed_add(Fixed3 a, Fixed3 b)
{
    uvec3 carry, carry1, carry2;
    Fixed3 r;
    r.tail = uaddCarry(a.tail, b.tail, carry);
    r.fraction = uaddCarry(uaddCarry(a.fraction, b.fraction, carry1), carry, carry2);
    r.cell = a.cell + b.cell + ivec3(carry1 + carry2);
    return r;
}

Fixed3 fixed_subtract(Fixed3 a, Fixed3 b)
{
    uvec3 borrow, borrow1, borrow2;
    Fixed3 r;
    r.tail = usubBorrow(a.tail, b.tail, borrow);
    r.fraction = usubBorrow(usubBorrow(a.fraction, b.fraction, borrow1), borrow, borrow2);
    r.cell = a.cell - b.cell - ivec3(borrow1 + borrow2);
    return r;
}

Fixed3 fixed_times(Fixed3 a, uint k)
{
    uvec3 high_tail, low_tail, high, low, carry;
    umulExtended(a.tail, uvec3(k), high_tail, low_tail);
    umulExtended(a.fraction, uvec3(k), high, low);
    Fixed3 r;
    r.tail = low_tail;
    r.fraction = uaddCarry(low, high_tail, carry);
    r.cell = a.cell * int(k) + ivec3(high + carry);
    return r;
}

Fixed3 fixed_half(Fixed3 a)
{
    return Fixed3(a.cell >> 1, (a.fraction >> 1) | (uvec3(a.cell) << 31), (a.tail >> 1) | (a.fraction << 31));
}

/* The fraction as float, below 1: 24 bits are exact. */
vec3 fixed_fraction(Fixed3 a)
{
    return vec3(ivec3(a.fraction >> 8)) * (1.0 / 16777216.0);
}

/* From `place` on. */
Near3 near_from(Fixed3 a, ivec3 place)
{
    return Near3(uvec3(a.cell - place) << 24 | a.fraction >> 8, a.fraction << 24 | a.tail >> 8);
}

Near3 near_add(Near3 a, Near3 b)
{
    uvec3 carry;
    Near3 r;
    r.low = uaddCarry(a.low, b.low, carry);
    r.high = a.high + b.high + carry;
    return r;
}

Near3 near_subtract(Near3 a, Near3 b)
{
    uvec3 borrow;
    Near3 r;
    r.low = usubBorrow(a.low, b.low, borrow);
    r.high = a.high - b.high - borrow;
    return r;
}

/* The whole part, 0 to 255, and the fraction as fixed_fraction has it. */
ivec3 near_cell(Near3 a)
{
    return ivec3(a.high >> 24);
}

vec3 near_fraction(Near3 a)
{
    return vec3(ivec3(a.high & 0xffffffu)) * (1.0 / 16777216.0);
}

Fixed3 fixed_near(Near3 a, ivec3 place)
{
    return Fixed3(near_cell(a) + place, a.high << 8 | a.low >> 24, a.low << 8);
}

dvec3 fixed_to(Fixed3 a)
{
    const double unit = 1.0LF / 4294967296.0LF;
    return dvec3(a.cell) + (dvec3(a.fraction) + dvec3(a.tail) * unit) * unit;
}
