"""The constraint solve: ``S = J M^-1 J^T``, its factor L D L^T, and the effect of row reactions on the
bodies.

A row that depends on earlier rows gets no pivot and no reaction, and the others are solved exactly, so that
redundant but consistent constraints do no harm.  All inner loops run along rows without a running sum: they
become vector code without a change in the order of any sum.

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, section 3.2 (elimination by J M^-1 J^T); Golub and
Van Loan, Matrix Computations, 2013, section 4.1 (L D L^T).
"""

from nutamill.base.kernel import kernel

DEPENDENT = 1e-12
"""A row depends on the earlier ones if elimination leaves less than this share [1] of its diagonal."""


@kernel
def divide_by_mass(bodies, inverse_inertia, vector, out):
    """Write ``M^-1`` times a load (n_bodies + 1, 6) [N, N m] in world axes: acceleration [m/s^2, rad/s^2], or
    the twist of a momentum.
    """
    for b in range(vector.shape[0]):
        I, m = inverse_inertia[b], bodies[b].inverse_mass
        x, y = vector[b], out[b]
        t0, t1, t2 = x[3], x[4], x[5]
        y[0], y[1], y[2] = m * x[0], m * x[1], m * x[2]
        y[3] = I[0, 0] * t0 + I[0, 1] * t1 + I[0, 2] * t2
        y[4] = I[1, 0] * t0 + I[1, 1] * t1 + I[1, 2] * t2
        y[5] = I[2, 0] * t0 + I[2, 1] * t1 + I[2, 2] * t2


@kernel
def divide_rows_by_mass(rows, bodies, inverse_inertia, jacobian, out):
    """Write ``M^-1 J^T`` row by row: `out` (n, 12) from `jacobian` (n, 12) of records (n,) that name two
    bodies.
    """
    for i in range(rows.shape[0]):
        J, W = jacobian[i], out[i]
        for side in range(2):
            at = 6 * side
            body = rows[i].body_a if side == 0 else rows[i].body_b
            I, m = inverse_inertia[body], bodies[body].inverse_mass
            for k in range(3):
                W[at + k] = m * J[at + k]
                W[at + 3 + k] = I[k, 0] * J[at + 3] + I[k, 1] * J[at + 4] + I[k, 2] * J[at + 5]


@kernel
def form_schur(pairs, gear_pairs, J, W, S_out):
    """Write the lower triangle of ``J M^-1 J^T`` into `S_out` (n_rows, n_rows), over the pairs of rows that
    share a moving body, and those of the second Jacobians of gears.
    """
    for i in range(S_out.shape[0]):
        for j in range(i + 1):
            S_out[i, j] = 0.0
    for m in range(pairs.shape[0]):
        i, j, p, q = pairs[m].row, pairs[m].other, pairs[m].block, pairs[m].other_block
        S_out[i, j] += (
            J[i, p] * W[j, q] + J[i, p + 1] * W[j, q + 1] + J[i, p + 2] * W[j, q + 2]
            + (J[i, p + 3] * W[j, q + 3] + J[i, p + 4] * W[j, q + 4] + J[i, p + 5] * W[j, q + 5])
        )  # fmt: skip
    for m in range(gear_pairs.shape[0]):
        pair = gear_pairs[m]
        for k in range(6):
            S_out[pair.row, pair.other] += (
                J[pair.jacobian, pair.block + k] * W[pair.other_jacobian, pair.other_block + k]
            )


@kernel
def factor(S_out, L_out, U_out, inverse_pivot_out):
    """Compute L D L^T of the lower triangle of `S_out`, row by row: L, its transpose U, and 1/D, which is 0
    for a dependent row.

    `S_out` (n_rows, n_rows) is destroyed.
    """
    for i in range(S_out.shape[0]):
        row = S_out[i]
        pivot = row[i]
        for k in range(i):
            y = row[k]
            if y == 0.0:
                L_out[i, k] = 0.0
                U_out[k, i] = 0.0
                continue
            scaled = y * inverse_pivot_out[k]
            u = U_out[k]
            for j in range(k + 1, i):
                row[j] -= y * u[j]
            L_out[i, k] = scaled
            u[i] = scaled
            pivot -= y * scaled
        inverse_pivot_out[i] = 1.0 / pivot if pivot > DEPENDENT * row[i] else 0.0


@kernel
def solve_factored(L, U, inverse_pivot, x_out):
    """Replace the right-hand side `x_out` (n_rows,) by the solution of ``S x = rhs``.

    Dependent rows get zero.
    """
    n = x_out.shape[0]
    for k in range(n):
        y, u = x_out[k], U[k]
        for j in range(k + 1, n):
            x_out[j] -= u[j] * y
    for k in range(n):
        x_out[k] *= inverse_pivot[k]
    for i in range(n - 1, -1, -1):
        y, row = x_out[i], L[i]
        for j in range(i):
            x_out[j] -= row[j] * y


@kernel
def add_row_reactions(rows, gears, rows_matrix, x, out):
    """Add ``rows_matrix^T x`` (rows (n_rows + n_gears, 12), x (n_rows,)) to the per-body vectors `out`
    (n_bodies + 1, 6).
    """
    for i in range(x.shape[0]):
        a, b, row, y = out[rows[i].body_a], out[rows[i].body_b], rows_matrix[i], x[i]
        for k in range(6):
            a[k] += row[k] * y
            b[k] += row[6 + k] * y
    for g in range(gears.shape[0]):
        a, b = out[gears[g].body_a], out[gears[g].body_b]
        row, y = rows_matrix[x.shape[0] + g], x[gears[g].row]
        for k in range(6):
            a[k] += row[k] * y
            b[k] += row[6 + k] * y
