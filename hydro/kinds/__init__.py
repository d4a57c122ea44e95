"""The kinds of deck, and what each does."""
