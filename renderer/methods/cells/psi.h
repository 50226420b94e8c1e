/* Partial pre-integration: what of the integral over a piece of a ray depends on optical depths only, and not
 * on the transfer function (Maximo et al. 2008, section 4.2.2, after Moreland and Angel 2004). */
#ifndef RENDERER_CELLS_PSI_H
#define RENDERER_CELLS_PSI_H

/* The mean transmittance over a piece along which extinction is linear, front at its start and back at its
 * end, both times the piece's length: the integral over x in [0,1] of exp(-(front x + (back - front) x^2 /
 * 2)). Right to 1e-14. With colour linear between c_front and c_back as well, and zeta the transmittance of
 * the whole piece, its colour is c_front (1 - psi) + c_back (psi - zeta). */
double vr_psi(double front, double back);

/* psi at n x n places, front fastest: gamma = depth / (1 + depth) is i / (n - 1). */
void vr_psi_table(float *table, int n);

#endif
