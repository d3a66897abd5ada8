"""The function the rivals differentiate, stated once: over numpy, jax.numpy and CasADi's SX alike.

Quadratic basis, cubic weight, frame held. Nodes are columns of offsets from the slave; `total` sums over them. All nodes
have to lie within the support radius, as those of the benchmark do: there is no choice in the weight.
"""

# Which moment of w a^i b^j each entry of the lower triangle of A is.
MOMENTS = [[0], [1, 3], [2, 4, 5], [3, 6, 7, 10], [4, 7, 8, 11, 12], [5, 8, 9, 12, 13, 14]]


def coefficients(a, b, z, total, sqrt):
    """alpha of the fit, lengths over R (Chamoret et al. 2008, eqs. 13 and 14)."""
    s = a * a + b * b
    w = 1 - 3 * s + 2 * s * sqrt(s)
    wa, wb = w * a, w * b
    waa, wab, wbb = wa * a, wa * b, wb * b
    waaa, waab, wabb, wbbb = waa * a, waa * b, wbb * a, wbb * b
    terms = [w, wa, wb, waa, wab, wbb, waaa, waab, wabb, wbbb]
    terms += [waaa * a, waaa * b, waab * b, wabb * b, wbbb * b]
    moments = [total(term) for term in terms]
    vector = [total(term * z) for term in terms[:6]]
    return solve([[moments[k] for k in row] for row in MOMENTS], vector)


def solve(matrix, vector):
    """A x = b by A = L D L^T, unrolled; `matrix` is a lower triangle."""
    size = len(vector)
    lower = [[None] * size for _ in range(size)]
    pivots = [None] * size
    for j in range(size):
        scaled = [lower[j][k] * pivots[k] for k in range(j)]
        pivots[j] = matrix[j][j] - sum(scaled[k] * lower[j][k] for k in range(j))
        for i in range(j + 1, size):
            lower[i][j] = (matrix[i][j] - sum(lower[i][k] * scaled[k] for k in range(j))) / pivots[j]
    x = list(vector)
    for i in range(size):
        x[i] = x[i] - sum(lower[i][k] * x[k] for k in range(i))
    x = [x[i] / pivots[i] for i in range(size)]
    for i in reversed(range(size)):
        x[i] = x[i] - sum(lower[k][i] * x[k] for k in range(i + 1, size))
    return x


def height(alpha, u):
    """f and its slopes at u."""
    a, b = u
    f_1 = alpha[1] + 2 * alpha[3] * a + alpha[4] * b
    f_2 = alpha[2] + alpha[4] * a + 2 * alpha[5] * b
    return alpha[0] + ((alpha[1] + f_1) * a + (alpha[2] + f_2) * b) / 2, f_1, f_2


def surface(alpha, radius, point):
    """Height of the surface over the slave at an in-plane offset that is held, in lengths."""
    return radius * height(alpha, (point[0] / radius, point[1] / radius))[0]


def residual(alpha, u):
    """Foot equations."""
    f, f_1, f_2 = height(alpha, u)
    return -u[0] - f * f_1, -u[1] - f * f_2


def gap(alpha, radius, foot, inverse, sqrt):
    """Gap (eq. 19). `foot` is the foot over R found beforehand and `inverse` the inverse Jacobian there, entries 11,
    12, 22; both are held. Two Newton steps give the derivatives of first and second order."""
    u = foot
    for _ in range(2):
        r_1, r_2 = residual(alpha, u)
        u = (
            u[0] - (inverse[0] * r_1 + inverse[1] * r_2),
            u[1] - (inverse[1] * r_1 + inverse[2] * r_2),
        )
    f, f_1, f_2 = height(alpha, u)
    return radius * (u[0] * f_1 + u[1] * f_2 - f) / sqrt(1 + f_1 * f_1 + f_2 * f_2)


def find_foot(alpha):
    """Foot and inverse Jacobian on reals, by Newton's method."""
    u = (0.0, 0.0)
    for _ in range(30):
        f, f_1, f_2 = height(alpha, u)
        j_11 = -1 - f_1 * f_1 - 2 * f * alpha[3]
        j_12 = -f_1 * f_2 - f * alpha[4]
        j_22 = -1 - f_2 * f_2 - 2 * f * alpha[5]
        determinant = j_11 * j_22 - j_12 * j_12
        inverse = (j_22 / determinant, -j_12 / determinant, j_11 / determinant)
        r_1, r_2 = residual(alpha, u)
        u = (
            u[0] - (inverse[0] * r_1 + inverse[1] * r_2),
            u[1] - (inverse[1] * r_1 + inverse[2] * r_2),
        )
    return u, inverse
