"""What tests share: README.md lists the modules."""
