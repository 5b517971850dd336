"""Contact laws, normal x tangential x rolling x cohesion: one stage, one file; one equation, one function.

Scalar kernels in the precision of their arguments, without branches, so that a batch of contacts becomes
vector code. The normal n points from the first particle to the second (or to the surface); velocities are
those of the first relative to the second at the common contact point, at mid-substep; forces and moments act
on the first particle.

Which law a stage takes is the type of a tag (`tags`), so that the choice is made when the loop is compiled.
"""
