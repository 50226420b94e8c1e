/* Index axes and patient axes. World is LPS: +x to the patient's left, +y to posterior, +z to superior. */
#include <brick/grid.h>

#include <math.h>
#include <string.h>

void brick_grid_spacing_mm(const struct brick_grid *grid, double spacing_mm[3])
{
    for (int c = 0; c < 3; c++)
        spacing_mm[c] =
            sqrt(grid->affine[0][c] * grid->affine[0][c] + grid->affine[1][c] * grid->affine[1][c] +
                 grid->affine[2][c] * grid->affine[2][c]);
}

double brick_grid_min_spacing_mm(const struct brick_grid *grid)
{
    double s[3];
    brick_grid_spacing_mm(grid, s);
    return fmin(s[0], fmin(s[1], s[2]));
}

double brick_affine_determinant(const double m[3][4])
{
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

void brick_affine_invert(const double m[3][4], double inverse[3][4])
{
    /* Scaling the columns to length 1 first keeps the cofactors in range for any legal spacing. */
    double n[3], u[3][4];
    for (int c = 0; c < 3; c++) {
        n[c] = sqrt(m[0][c] * m[0][c] + m[1][c] * m[1][c] + m[2][c] * m[2][c]);
        for (int r = 0; r < 3; r++)
            u[r][c] = m[r][c] / n[c];
    }
    for (int r = 0; r < 3; r++)
        u[r][3] = m[r][3];
    double det = brick_affine_determinant(u);
    for (int r = 0; r < 3; r++) {
        int r1 = (r + 1) % 3, r2 = (r + 2) % 3;
        for (int c = 0; c < 3; c++) {
            int c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            inverse[r][c] = (u[c1][r1] * u[c2][r2] - u[c1][r2] * u[c2][r1]) / det / n[r];
        }
        inverse[r][3] = -(inverse[r][0] * m[0][3] + inverse[r][1] * m[1][3] + inverse[r][2] * m[2][3]);
    }
}

/* World axis and sign of a letter. */
static int letter_axis(char letter, double *sign)
{
    static const char positive[] = "LPS", negative[] = "RAI";
    for (int a = 0; a < 3; a++) {
        if (letter == positive[a] || letter == positive[a] + 32) {
            *sign = 1.0;
            return a;
        }
        if (letter == negative[a] || letter == negative[a] + 32) {
            *sign = -1.0;
            return a;
        }
    }
    return -1;
}

int brick_affine_from_axes(const char *code, const double spacing_mm[3], const double origin_mm[3],
                           double affine[3][4], struct brick_error *err)
{
    double m[3][4] = {{0}};
    int used = 0;
    for (int c = 0; c < 3; c++) {
        double sign = 0.0;
        int a = strlen(code) == 3 ? letter_axis(code[c], &sign) : -1;
        if (a < 0 || (used & 1 << a))
            return brick_fail(err, BRICK_ERR_ARGUMENT,
                              "axes '%s' are not three letters, one each of L or R, P or A, S or I", code);
        used |= 1 << a;
        m[a][c] = sign * spacing_mm[c];
        m[c][3] = origin_mm[c];
    }
    memcpy(affine, m, sizeof m);
    return BRICK_OK;
}

void brick_affine_axes(const double affine[3][4], char code[4])
{
    /* The assignment of index axes to patient axes with the largest total cosine: distinct letters always. */
    static const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    double n[3], best = -1.0;
    const int *order = orders[0];
    for (int c = 0; c < 3; c++)
        n[c] = sqrt(affine[0][c] * affine[0][c] + affine[1][c] * affine[1][c] + affine[2][c] * affine[2][c]);
    for (int i = 0; i < 6; i++) {
        double sum = 0.0;
        for (int c = 0; c < 3; c++)
            sum += fabs(affine[orders[i][c]][c]) / n[c];
        if (sum > best) {
            best = sum;
            order = orders[i];
        }
    }
    for (int c = 0; c < 3; c++)
        code[c] = affine[order[c]][c] < 0.0 ? "RAI"[order[c]] : "LPS"[order[c]];
    code[3] = 0;
}
