"""The tables of an FMU as C text: what its skeleton knows of the machine."""

import math

from nutamill.charge.laws.lanes import BATCH
from nutamill.charge.model import PADDING
from nutamill.export.fmu.interface import Interface

TAKES = {"sum": "SUM", "product": "PRODUCT", "resultant": "RESULTANT", "lag": "LAG"}
"""Names in C of what a series is taken as."""

ECX_1 = {"sse4.2": 20, "avx": 28, "fma": 12}
EBX_7 = {
    **{"bmi": 3, "avx2": 5, "bmi2": 8},
    **{"avx512f": 16, "avx512dq": 17, "avx512cd": 28, "avx512bw": 30, "avx512vl": 31},
}
"""Groups of instructions that kernels may use beyond what every x86-64 processor has, with the bits by which
CPUID shows them in leaf 1, register ECX, and leaf 7, register EBX [Intel, Software Developer's Manual 2A].
"""
OSXSAVE = 27
"""Bit of leaf 1, register ECX: XGETBV shows which registers the operating system saves."""
SAVED = {"avx": 0x6, "avx512f": 0xE0}
"""Bits of the registers that a group of instructions needs, as XGETBV shows them."""

HEADER = """/* Tables of one machine, written by nutamill export fmu. */
#ifndef NUTAMILL_MODEL_H
#define NUTAMILL_MODEL_H
#include <stdint.h>

#define TOKEN "{token}"
#define BLOCK_SIZE {block_size}
#define INNER_STEP {step}
#define TIME_AT {time}
#define ROW_AT {row}
#define INPUTS_AT {inputs_at}
#define N_COLUMNS {columns}
#define N_SERIES {n_series}
#define N_SLOTS (N_COLUMNS + N_SERIES)
#define N_INPUTS {n_inputs}
#define N_VARIABLES {n_variables}
#define MOST_TERMS {most_terms}
#define PI {pi}
{processor}

enum kind {{ CLOCK, IN_BLOCK, IN_SLOTS }};
enum input_kind {{ PLAIN, SPEED }};
enum take {{ SUM, PRODUCT, RESULTANT, LAG }};

struct variable {{ enum kind kind; int settable; int64_t at; }};
struct input {{ enum input_kind kind; int64_t at, motion; }};
struct term {{ int slot; double sign, zero; }};
struct series {{ enum take take; int first, count; }};

{whole}
extern const unsigned char nutamill_block[BLOCK_SIZE];
static const struct variable variables[] = {{
{variables}
}};
static const struct input inputs[] = {{
{inputs}
}};
static const struct term terms[] = {{
{terms}
}};
static const struct series series[] = {{
{series}
}};
#endif
"""


WHOLE = """
/* The charge: places in the block, and arrays that grow with its lists. */
struct growing {{ int64_t entry; int dimensions, grows; int64_t item; int lanes; }};
struct saved {{ int64_t starts_at, count, partners; }};
{places}
#define PER_ROW {per_row}
#define CHUNK {chunk}
#define SURFACE_LANES {surface_lanes}
#define PADDING {padding}
#define BATCH {batch}
#define FIRST_WRENCH {first_wrench}
#define N_WRENCH {n_wrench}
#define N_GROWING {n_growing}
#define N_SAVED {n_saved}
static const struct growing growing[] = {{
{growing}
}};
static const struct saved saved[] = {{
{saved}
}};
"""


def _whole(interface: Interface) -> str:
    """Return the tables of the charge, empty for a mechanism without it."""
    whole = interface.whole
    if whole is None:
        return ""
    return WHOLE.format(
        places="\n".join(f"#define {name} {place}" for name, place in whole.places.items()),
        per_row=interface.model.plan.windows_per_row,
        chunk=whole.chunk,
        surface_lanes=whole.surface_lanes,
        padding=PADDING,
        batch=BATCH,
        first_wrench=whole.wrench[0],
        n_wrench=whole.wrench[1],
        n_growing=len(whole.growing),
        n_saved=len(whole.saved),
        growing="\n".join(
            f"{{{one.entry}, {one.dimensions}, {one.grows}, {one.item}, {int(one.lanes)}}},"
            for one in whole.growing
        ),
        saved="\n".join(f"{{{at}, {count}, {entry}}}," for at, count, entry in whole.saved),
    )


def header(interface: Interface, token: str, features: str) -> str:
    """Return model.h of a machine.

    Parameters
    ----------
    interface : the machine
    token : what identifies its description
    features : instructions that its kernels were emitted with, as LLVM writes them
    """
    variables = [f"{{{v.kind}, {int(v.causality == 'input')}, {v.at}}}," for v in interface.variables]
    inputs = [f"{{{given.kind}, {given.at}, {given.motion}}}," for given in interface.inputs]
    terms: list[str] = []
    series: list[str] = []
    for made in interface.made:
        series.append(f"{{{TAKES[made.take]}, {len(terms)}, {len(made.terms)}}},")
        terms += [f"{{{term.slot}, {_exact(term.sign)}, {_exact(term.zero)}}}," for term in made.terms]
    places = interface.block.places
    state = "state" if interface.whole is None else "state.mechanism"
    return HEADER.format(
        token=token,
        block_size=len(interface.block.content),
        step=_exact(interface.model.plan.dt),
        time=places[f"{state}.time"],
        row=places["row"],
        inputs_at=places["inputs"],
        columns=interface.model.readout.n_columns,
        n_series=len(series),
        n_inputs=len(inputs),
        n_variables=len(variables),
        most_terms=max(len(made.terms) for made in interface.made),
        pi=_exact(math.pi),
        processor=_processor(features),
        whole=_whole(interface),
        variables="\n".join(variables),
        inputs="\n".join(inputs),
        terms="\n".join(terms),
        series="\n".join(series),
    )


def _processor(features: str) -> str:
    """Return the masks of what a processor must have for these instructions, as macros."""
    needed = {name.removeprefix("+") for name in features.split(",") if name.startswith("+")}
    saved = sum(bits for name, bits in SAVED.items() if name in needed)
    first = sum(1 << bit for name, bit in ECX_1.items() if name in needed) | bool(saved) << OSXSAVE
    seventh = sum(1 << bit for name, bit in EBX_7.items() if name in needed)
    masks = {"NEEDS_ECX_1": first, "NEEDS_EBX_7": seventh, "NEEDS_SAVED": saved}
    return "\n".join(f"#define {name} {mask:#x}u" for name, mask in masks.items())


def _exact(value: float) -> str:
    """Return a float in C with all its bits."""
    return float(value).hex()
