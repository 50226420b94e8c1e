/* exp for x <= 0, better than the built-in promises: within 2 units in the last place, and exp(x) - 1 within 2 of its
 * own, however small x is. x = n ln 2 + r with |r| <= ln(2)/2, then exp(x) = 2^n (1 + p(r)); ln 2 is split so that
 * n * LN2_HIGH is exact. Below -87 the result is exp(-87) = 1.6e-38 (minus 1). */
#define LN2_HIGH 0.693359375
#define LN2_LOW  -2.12194440e-4

float exponential_part(float x, out float scale)
{
    precise float y = max(x, -87.0);
    precise float n = floor(y * 1.44269504 + 0.5);
    precise float r = (y - n * LN2_HIGH) - n * LN2_LOW;
    precise float p = 1.0 / 720.0 + r * (1.0 / 5040.0);
    p = 1.0 / 120.0 + r * p;
    p = 1.0 / 24.0 + r * p;
    p = 1.0 / 6.0 + r * p;
    p = 0.5 + r * p;
    p = r + (r * r) * p;
    scale = uintBitsToFloat(uint(int(n) + 127) << 23);
    return p;
}

/* exp(x), x <= 0. */
float exponential(float x)
{
    float scale, p = exponential_part(x, scale);
    precise float y = scale * (1.0 + p); /* scale * p alone may be too small for a normal float */
    return y;
}

/* 1 - exp(-x), x >= 0: the opacity of optical depth x. */
float opacity(float x)
{
    float scale, p = exponential_part(-x, scale);
    precise float y = (1.0 - scale) - scale * p;
    return y;
}
