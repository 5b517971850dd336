"""What a designer reads from a result: orders, load paths, mounts, clearance, life.  Only the file is read;
no engine is needed.
"""
