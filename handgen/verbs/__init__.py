"""The verbs of the command line: arguments in, one call, a table or JSON out.

Nothing heavy is imported before a verb runs.
"""

from handgen.verbs import bench, making, showing, simulating

VERBS = {**making.VERBS, **showing.VERBS, **bench.VERBS, **simulating.VERBS}
