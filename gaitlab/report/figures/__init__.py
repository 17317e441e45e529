"""The figures of a report, one file each. They draw what they are given and choose nothing."""
