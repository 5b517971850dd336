"""Contact laws, normal x tangential x rolling x cohesion: one law, one file; one equation, one function.

Scalar kernels in the precision of their arguments, without branches, so that a batch of contacts becomes
vector code.  Vectors are 3-tuples.  The normal n points from the first particle to the second (or to the
surface); velocities are those of the first relative to the second at the common contact point, at
mid-substep; forces and moments act on the first particle.

| file | holds |
|---|---|
| `linear`, `hysteretic`, `hertz` | normal laws: numbers, force, energy, closed form, terms |
| `displacement`, `incremental` | friction |
| `incremental_dashpot` | friction with a tangential dashpot |
| `no_rolling`, `type_a`, `type_c`, `type_c_direct` | resistance to rolling |
| `no_cohesion`, `area` | cohesion |
| `composition` | registry of the laws; the whole law of one contact |
| `pair` | numbers of two materials, their row in the table of the charge, two springs in series |
| `spring` | spring with a limit, for friction and rolling |
| `deepest` | deepest overlap of a contact, whose work of loading is booked |
| `oscillator` | restitution, duration and overlap of a damped oscillator |
| `terms` | what the files state about their laws, in the terms of other programs |
| `impact` | head-on contact under any law, cohesion included |

To add a law, write its file and enter it in `composition`.  If case files are to name it, enter its name and
the numbers of a pair that it reads in `nutamill.case.contact_laws`; a contract test compares the two.

Which law a stage takes is the type of a tag, so that the choice is made when the loop is compiled.
"""
