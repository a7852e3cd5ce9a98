"""Arguments of the commands: a module for each, named as the module of its command, which it imports when it runs."""
