/* Where a surface is in a cell: the trilinear field along a straight way inside a cell is a cubic, whose coefficients are exact
 * to double precision (renderer/exact/cubic.c does the same on the host). */
#if MODE == MODE_ISO && defined CUBIC

/* Of a way from t to t + d, in the cell's coordinates; c[i] belongs to s^i, s in [0,1]. */
dvec4 cubic_in_cell(Cell cell, dvec3 t, dvec3 d)
{
    dvec4 a = dvec4(cell.low.xz, cell.high.xz), rise = dvec4(cell.low.yw, cell.high.yw) - a;
    dvec4 x0 = a + t.x * rise, x1 = d.x * rise;
    dvec2 rise0 = x0.yw - x0.xz, rise1 = x1.yw - x1.xz;
    dvec2 y0 = x0.xz + t.y * rise0, y1 = x1.xz + t.y * rise1 + d.y * rise0, y2 = d.y * rise1;
    dvec3 low = dvec3(y0.x, y1.x, y2.x), up = dvec3(y0.y, y1.y, y2.y) - low;
    return dvec4(low + t.z * up, 0.0LF) + dvec4(0.0LF, d.z * up);
}

bool cubic_above(dvec4 c, double s)
{
    return c[0] + s * (c[1] + s * (c[2] + s * c[3])) >= 0.0LF;
}

/* The first s at which c, less the isovalue, changes side. At 0 it is on the side `above` and at 1 on the other: that the
 * samples say, who decide for all methods. Between its turning points a cubic changes side once. */
double cubic_crossing(dvec4 c, bool above)
{
    double inside = c[2] * c[2] - 3.0LF * c[1] * c[3], from = 0.0LF, to = 1.0LF;
    if (inside > 0.0LF) {
        double z = -(c[2] + (c[2] < 0.0LF ? -1.0LF : 1.0LF) * sqrt(inside));
        double r0 = c[1] / z, r1 = z / (3.0LF * c[3]);
        double first = min(r0, r1), second = max(r0, r1);
        bool one = first > 0.0LF && first < 1.0LF, two = second > 0.0LF && second < 1.0LF;
        if (one && cubic_above(c, first) != above) {
            to = first;
        } else {
            from = one ? first : 0.0LF;
            if (two && cubic_above(c, second) != above)
                to = second;
            else if (two)
                from = second;
        }
    }
    for (int i = 0; i < 50; i++) {
        double middle = 0.5LF * (from + to);
        if (cubic_above(c, middle) == above)
            from = middle;
        else
            to = middle;
    }
    return to;
}
#endif
