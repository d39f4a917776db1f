"""``python -m sosbook.pendulum``: see `sosbook.pendulum.command`."""

from ..runtime.later import or_exit

if __name__ == "__main__":
    or_exit("pendulum.command", "main")()
