"""What precedes a fall: from many logs, the gait cycle in which each robot last stood well.

`standing` says until when a robot stood well, `measures` what is measured in one gait cycle,
`courses` what changes from cycle to cycle, `comparing` sets like beside like, `firmness` is the
mechanics beside it, `accounts` and `tables` tell all of it.
"""
