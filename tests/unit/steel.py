"""Steel balls for the cases of tests: TOML of their material, their contact law and the pair."""

STEEL = """
[materials.steel]
density       = "7800 kg/m^3"
young_modulus = "210 GPa"
poisson_ratio = 0.3
[contact]
softening = 1e-3
[contact.pairs.steel-steel]
sliding_friction = 0.3
restitution      = 0.6
"""
