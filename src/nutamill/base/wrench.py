"""Names of the components of a wrench, as series and columns have them."""

__all__ = ["WRENCH"]

WRENCH = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z")
"""Force [N] and moment [N m]; axes and point are those of the series."""
