"""Support behind ``./er``: environment, build, dispatch of commands; standard library only."""
