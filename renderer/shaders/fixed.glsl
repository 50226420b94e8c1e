/* Positions along a ray in 32.64 fixed point: sample k's position is first + k * step by integer arithmetic, so it does not
 * depend on how a method came to sample k, nor on bricks or slots. 64 fraction bits keep the sum right to 2^-40
 * voxel after 2^24 steps. */
struct Fixed3 {
    ivec3 cell;
    uvec3 fraction, tail; /* 2^-32, 2^-64 */
};

Fixed3 fixed_from(dvec3 p)
{
    const dvec3 two32 = dvec3(4294967296.0LF), most = dvec3(4294967295.0LF);
    dvec3 whole = floor(p);
    dvec3 scaled = (p - whole) * two32;
    dvec3 high = min(floor(scaled), most); /* p just below an integer: p - whole rounds to 1 */
    dvec3 low = clamp(floor((scaled - high) * two32), dvec3(0.0LF), most);
    return Fixed3(ivec3(whole), uvec3(high), uvec3(low));
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
    return vec3(a.fraction >> 8) * (1.0 / 16777216.0);
}

dvec3 fixed_to(Fixed3 a)
{
    const double unit = 1.0LF / 4294967296.0LF;
    return dvec3(a.cell) + (dvec3(a.fraction) + dvec3(a.tail) * unit) * unit;
}
