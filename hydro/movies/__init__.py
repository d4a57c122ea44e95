"""Movies: frames that are kept while a run goes on, and how they become a film."""
