"""The grains themselves: event-driven molecular dynamics of inelastic smooth hard disks in the box of a deck.

What events change and the box they happen in are arrays (`state`, `books`). Events are foreseen (`prediction`, with
the `cell_list`), wait in a `queue`, and happen one by one (`events`, `collisions`, `walls`). `dynamics` chooses the
cells (`cells`) and advances all in time; `integrator` shows that to the main loop as fields (`fields`) on a mesh.
"""
