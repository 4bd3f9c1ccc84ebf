"""The printed page of ``vibro report``, and the texts that it shares with the command line."""
