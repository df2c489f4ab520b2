#include <stddef.h>

extern double chain_parameters[];
double chain_parameters[] = {1, 1, 0.25}; /* m, k, beta */

void fput_force(size_t n, const double *q, double *a);

/* m q_i'' = F(q_{i+1} - q_i) - F(q_i - q_{i-1}), F(d) = k d + beta d^3. */
void fput_force(size_t n, const double *q, double *restrict a)
{
    const double k = chain_parameters[1] / chain_parameters[0];
    const double beta = chain_parameters[2] / chain_parameters[0];

    for (size_t i = 1; i + 1 < n; i++) {
        const double r = q[i + 1] - q[i], l = q[i] - q[i - 1];
        a[i] = r * (k + beta * r * r) - l * (k + beta * l * l);
    }
    const double first = n > 1 ? q[1] - q[0] : -q[0], last = n > 1 ? q[n - 1] - q[n - 2] : q[0];
    a[0] = first * (k + beta * first * first) - q[0] * (k + beta * q[0] * q[0]);
    if (n > 1)
        a[n - 1] = -q[n - 1] * (k + beta * q[n - 1] * q[n - 1]) -
                   last * (k + beta * last * last);
}
