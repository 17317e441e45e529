"""What precedes a fall: from many logs, the gait cycle in which each robot last stood well.

`standing` says until when a robot stood well, `measures` what is measured in one gait cycle,
`courses` what changes from cycle to cycle, and `reading` takes all three from a store. `comparing`
sets like beside like, `scene` makes every comparison of a few variants on a few grounds; `firmness`
is the mechanics beside it. `accounts` tells it in words, `tables` in tables, `pair` in the pictures
of one fall.
"""
