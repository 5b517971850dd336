"""Moves between rows (one particle, eight numbers) and columns (one number, many contacts), eight contacts at
a time.

A compiler does not recognise these transpositions.  In single precision they are written once as
target-independent LLVM vector code, which becomes AVX, AVX-512 or NEON.  In double precision, and without the
compiler, the plain Python below is used.  It states what each move does, and the vector code is tested
against it.

In all of them `columns` and `columns_out` are flat arrays of rows of `BATCH` lanes, `lane` the first of eight
lanes, `first` the first of eight entries of an index array.
"""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload

from nutamill.charge.laws.lanes import BATCH

WIDTH = 8
"""Contacts moved at a time [1]."""


def gather_rows(rows, index, first, lane, at, columns_out):
    """Load the eight numbers of ``rows[index[first + e]]``, e = 0 to 7, into the columns `at` to `at` + 7."""
    for e in range(WIDTH):
        for k in range(8):
            columns_out[(at + k) * BATCH + lane + e] = rows[index[first + e], k]


def add_rows(index, first, columns, lane, at, rows_out):
    """Add columns `at` to `at` + 7 to ``rows_out[index[first + e]]``. An index may occur twice."""
    for e in range(WIDTH):
        for k in range(8):
            rows_out[index[first + e], k] += columns[(at + k) * BATCH + lane + e]


def set_rows(index, first, columns, lane, at, rows_out):
    """Write the columns `at` to `at` + 7 to ``rows_out[index[first + e]]``."""
    for e in range(WIDTH):
        for k in range(8):
            rows_out[index[first + e], k] = columns[(at + k) * BATCH + lane + e]


def copy_lanes(source, at, to, target_out):
    """Copy `BATCH` numbers of the flat array `source` from index `at` on to those of `target_out` from index
    `to` on.
    """
    for b in range(BATCH):
        target_out[to + b] = source[at + b]


def set_points(index, first, fixed, lane, points_out):
    """Write the columns 0 to 3 of `fixed` to ``points_out[index[first + e]]``, e = 0 to 7."""
    for e in range(WIDTH):
        for k in range(4):
            points_out[index[first + e], k] = fixed[k * BATCH + lane + e]


def negated_radii(points, index, first, at, local_out):
    """Copy ``points[index[first + e]]`` with the radius negated to ``local_out[at + e]``, e = 0 to 7."""
    for e in range(WIDTH):
        for k in range(3):
            local_out[at + e, k] = points[index[first + e], k]
        local_out[at + e, 3] = -points[index[first + e], 3]


def gather_differences(points, second, local, owner, first, lane, columns_out):
    """Write ``points[second] - local[owner]`` [fixed point], as real numbers, to the columns 0 to 3: distance
    vector and sum of radii.
    """
    for e in range(WIDTH):
        for k in range(4):
            columns_out[k * BATCH + lane + e] = float(
                int(points[second[first + e], k]) - int(local[owner[first + e], k])
            )


def touching(points, second, local, owner, first):
    """Set bit e where candidate ``first + e`` is closer than the sum of the radii."""
    mask = 0
    for e in range(WIDTH):
        a = second[first + e]
        b = owner[first + e]
        x = float(int(points[a, 0]) - int(local[b, 0]))
        y = float(int(points[a, 1]) - int(local[b, 1]))
        z = float(int(points[a, 2]) - int(local[b, 2]))
        r = float(int(points[a, 3]) - int(local[b, 3]))
        if x * x + y * y + z * z < r * r:
            mask |= 1 << e
    return mask


_F32 = ir.FloatType()
_I32 = ir.IntType(32)
_I64 = ir.IntType(64)
_V8 = ir.VectorType(_F32, 8)
_V4I = ir.VectorType(_I32, 4)
_V8I = ir.VectorType(_I32, 8)
_WORD = 4
# lane choices of the three rounds of an 8 x 8 transposition: pairs of rows, pairs of lanes, halves
_UNPACK = [0, 8, 1, 9, 4, 12, 5, 13], [2, 10, 3, 11, 6, 14, 7, 15]
_PAIRS = [0, 1, 8, 9, 4, 5, 12, 13], [2, 3, 10, 11, 6, 7, 14, 15]
_HALVES = [0, 1, 2, 3, 8, 9, 10, 11], [4, 5, 6, 7, 12, 13, 14, 15]

# lane choices from four columns of eight to eight rows of four: columns x with z and y with r, then both
_INTERLEAVED = [0, 8, 1, 9, 2, 10, 3, 11], [4, 12, 5, 13, 6, 14, 7, 15]
_ROWS = [[2 * e, 8 + 2 * e, 2 * e + 1, 9 + 2 * e] for e in range(4)]


def _shuffle(builder, a, b, lanes):
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(_I32, len(lanes)), list(lanes)))


def _transpose4(builder, rows):
    """Turn four vectors whose halves are rows e and e + 4 into four columns of eight."""
    a, b = (_shuffle(builder, rows[0], rows[1], lanes) for lanes in _UNPACK)
    c, d = (_shuffle(builder, rows[2], rows[3], lanes) for lanes in _UNPACK)
    return [_shuffle(builder, p, q, lanes) for p, q in ((a, c), (b, d)) for lanes in _PAIRS]


def _transpose8(builder, rows):
    """Turn eight rows of eight into eight columns of eight, its own inverse."""
    halves = [[_shuffle(builder, rows[k], rows[k + 4], lanes) for k in range(4)] for lanes in _HALVES]
    return _transpose4(builder, halves[0]) + _transpose4(builder, halves[1])


def _data(context, builder, signature, args, k):
    return context.make_array(signature.args[k])(context, builder, args[k]).data


def _load(builder, pointer, vector):
    value = builder.load(builder.bitcast(pointer, vector.as_pointer()))
    value.align = _WORD
    return value


def _store(builder, value, pointer):
    builder.store(value, builder.bitcast(pointer, value.type.as_pointer())).align = _WORD


def _row(builder, base, index, first, e, width):
    """Return a pointer to the row (of `width` words) that entry ``first + e`` of `index` names."""
    entry = builder.load(builder.gep(index, [builder.add(first, ir.Constant(_I64, e))]))
    return builder.gep(base, [builder.mul(builder.zext(entry, _I64), ir.Constant(_I64, width))])


def _column(builder, columns, lane, at, k):
    place = builder.mul(builder.add(at, ir.Constant(_I64, k)), ir.Constant(_I64, BATCH))
    return builder.gep(columns, [builder.add(place, lane)])


def _differences(builder, points, second, local, owner, first):
    rows = []
    for e in range(4):
        ends = []
        for base, index in ((points, second), (local, owner)):
            lower, upper = (_load(builder, _row(builder, base, index, first, q, 4), _V4I) for q in (e, e + 4))
            ends.append(_shuffle(builder, lower, upper, range(8)))
        rows.append(builder.sub(*ends))
    return [builder.sitofp(column, _V8) for column in _transpose4(builder, rows)]


@intrinsic
def _gather_rows(typing_context, rows, index, first, columns, lane, at):
    def code(context, builder, signature, args):
        base, entries, out = (_data(context, builder, signature, args, k) for k in (0, 1, 3))
        loaded = [_load(builder, _row(builder, base, entries, args[2], e, 8), _V8) for e in range(8)]
        for k, column in enumerate(_transpose8(builder, loaded)):
            _store(builder, column, _column(builder, out, args[4], args[5], k))
        return context.get_dummy_value()

    return types.void(rows, index, types.int64, columns, types.int64, types.int64), code


def _scatter(builder, context, signature, args, add):
    base, entries, out = (_data(context, builder, signature, args, k) for k in (0, 1, 3))
    loaded = [_load(builder, _column(builder, out, args[4], args[5], k), _V8) for k in range(8)]
    for e, row in enumerate(_transpose8(builder, loaded)):
        place = _row(builder, base, entries, args[2], e, 8)
        _store(builder, builder.fadd(_load(builder, place, _V8), row) if add else row, place)
    return context.get_dummy_value()


@intrinsic
def _add_rows(typing_context, rows, index, first, columns, lane, at):
    def code(context, builder, signature, args):
        return _scatter(builder, context, signature, args, True)

    return types.void(rows, index, types.int64, columns, types.int64, types.int64), code


@intrinsic
def _set_rows(typing_context, rows, index, first, columns, lane, at):
    def code(context, builder, signature, args):
        return _scatter(builder, context, signature, args, False)

    return types.void(rows, index, types.int64, columns, types.int64, types.int64), code


@intrinsic
def _gather_differences(typing_context, points, second, local, owner, first, columns, lane):
    def code(context, builder, signature, args):
        p, j, q, i, out = (_data(context, builder, signature, args, k) for k in (0, 1, 2, 3, 5))
        for k, column in enumerate(_differences(builder, p, j, q, i, args[4])):
            _store(builder, column, _column(builder, out, args[6], ir.Constant(_I64, 0), k))
        return context.get_dummy_value()

    return types.void(points, second, local, owner, types.int64, columns, types.int64), code


@intrinsic
def _touching(typing_context, points, second, local, owner, first):
    def code(context, builder, signature, args):
        p, j, q, i = (_data(context, builder, signature, args, k) for k in range(4))
        x, y, z, r = _differences(builder, p, j, q, i, args[4])
        squares = [builder.fmul(c, c) for c in (x, y, z)]
        distance2 = builder.fadd(builder.fadd(squares[0], squares[1]), squares[2])
        mask = builder.bitcast(builder.fcmp_ordered("<", distance2, builder.fmul(r, r)), ir.IntType(8))
        return builder.zext(mask, _I64)

    return types.int64(points, second, local, owner, types.int64), code


@intrinsic
def _copy_lanes(typing_context, source, at, target, to):
    def code(context, builder, signature, args):
        base, out = (_data(context, builder, signature, args, k) for k in (0, 2))
        lanes = _load(builder, builder.gep(base, [args[1]]), ir.VectorType(base.type.pointee, BATCH))
        if base.type.pointee != out.type.pointee:
            lanes = builder.fptosi(lanes, ir.VectorType(out.type.pointee, BATCH))
        _store(builder, lanes, builder.gep(out, [args[3]]))
        return context.get_dummy_value()

    return types.void(source, types.int64, target, types.int64), code


@overload(copy_lanes, inline="always")
def _choose_copy_lanes(source, at, to, target_out):
    return lambda source, at, to, target_out: _copy_lanes(source, at, target_out, to)


@intrinsic
def _set_points(typing_context, points, index, first, fixed, lane):
    def code(context, builder, signature, args):
        base, entries, columns = (_data(context, builder, signature, args, k) for k in (0, 1, 3))
        a, b, c, d = (
            _load(builder, _column(builder, columns, args[4], ir.Constant(_I64, 0), k), _V8I)
            for k in range(4)
        )
        # two rounds: pairs of columns to halves of rows, halves to rows
        pairs = [(_shuffle(builder, a, c, lanes), _shuffle(builder, b, d, lanes)) for lanes in _INTERLEAVED]
        e = 0
        for low, high in pairs:
            for lanes in _ROWS:
                row = _shuffle(builder, low, high, lanes)
                _store(builder, row, _row(builder, base, entries, args[2], e, 4))
                e += 1
        return context.get_dummy_value()

    return types.void(points, index, types.int64, fixed, types.int64), code


@intrinsic
def _negated_radii(typing_context, points, index, first, local, at):
    def code(context, builder, signature, args):
        base, entries, out = (_data(context, builder, signature, args, k) for k in (0, 1, 3))
        sign = ir.Constant(_V4I, [1, 1, 1, -1])
        for e in range(8):
            row = builder.mul(_load(builder, _row(builder, base, entries, args[2], e, 4), _V4I), sign)
            place = builder.mul(builder.add(args[4], ir.Constant(_I64, e)), ir.Constant(_I64, 4))
            _store(builder, row, builder.gep(out, [place]))
        return context.get_dummy_value()

    return types.void(points, index, types.int64, local, types.int64), code


@overload(set_points, inline="always")
def _choose_set_points(index, first, fixed, lane, points_out):
    if points_out.dtype == types.int32:
        return lambda index, first, fixed, lane, points_out: _set_points(
            points_out, index, first, fixed, lane
        )
    return set_points


@overload(negated_radii, inline="always")
def _choose_negated_radii(points, index, first, at, local_out):
    if points.dtype == types.int32:
        return lambda points, index, first, at, local_out: _negated_radii(points, index, first, local_out, at)
    return negated_radii


@overload(gather_rows, inline="always")
def _choose_gather_rows(rows, index, first, lane, at, columns_out):
    if rows.dtype == types.float32:
        return lambda rows, index, first, lane, at, columns_out: _gather_rows(
            rows, index, first, columns_out, lane, at
        )
    return gather_rows


@overload(add_rows, inline="always")
def _choose_add_rows(index, first, columns, lane, at, rows_out):
    if rows_out.dtype == types.float32:
        return lambda index, first, columns, lane, at, rows_out: _add_rows(
            rows_out, index, first, columns, lane, at
        )
    return add_rows


@overload(set_rows, inline="always")
def _choose_set_rows(index, first, columns, lane, at, rows_out):
    if rows_out.dtype == types.float32:
        return lambda index, first, columns, lane, at, rows_out: _set_rows(
            rows_out, index, first, columns, lane, at
        )
    return set_rows


@overload(gather_differences, inline="always")
def _choose_gather_differences(points, second, local, owner, first, lane, columns_out):
    if points.dtype == types.int32:
        return lambda points, second, local, owner, first, lane, columns_out: _gather_differences(
            points, second, local, owner, first, columns_out, lane
        )
    return gather_differences


@overload(touching, inline="always")
def _choose_touching(points, second, local, owner, first):
    if points.dtype == types.int32:
        return lambda points, second, local, owner, first: _touching(points, second, local, owner, first)
    return touching
