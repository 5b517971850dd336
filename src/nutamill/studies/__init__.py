"""Many runs that belong together: sweeps over keys of a case, and fits of keys to measurements."""
