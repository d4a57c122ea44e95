"""When a temperature is one."""

# T is what is left of the energy per grain when that of the flow is taken away: below this share of it, round-off.
COLDEST = 1e-14
