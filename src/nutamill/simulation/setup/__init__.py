"""From a case to the arrays of the engines: the only room that turns a mill into bodies, joints and loads."""
