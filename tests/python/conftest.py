"""For all tests."""

import signal

# Programs started in the background of a shell may have been told to ignore interrupts, and would
# hand that down to those that the tests start and interrupt.
if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
