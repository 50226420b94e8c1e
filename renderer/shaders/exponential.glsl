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

/* x^n for 0 <= x <= 1, n >= 0, right to 2e-7 (1 + n |ln x|): the built-in promises less the larger n is. x = 2^e m with m from
 * sqrt(1/2) to sqrt(2), ln m = 2 artanh((m - 1) / (m + 1)) by its series. */
float power(float x, float n)
{
    int exponent = (floatBitsToInt(x) - 0x3f3504f3) >> 23;
    float e = float(exponent), m = intBitsToFloat(floatBitsToInt(x) - (exponent << 23));
    precise float s = (m - 1.0) / (m + 1.0);
    precise float z = s * s;
    precise float p = 2.0 / 7.0 + z * (2.0 / 9.0);
    p = 2.0 / 5.0 + z * p;
    p = 2.0 / 3.0 + z * p;
    p = s * (2.0 + z * p);
    precise float logarithm = e * LN2_HIGH + (e * LN2_LOW + p);
    precise float y = n * logarithm;
    return x >= 1.17549435e-38 ? exponential(min(y, 0.0)) : 0.0;
}
