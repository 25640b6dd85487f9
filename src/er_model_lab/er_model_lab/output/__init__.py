"""Results for people: text that terminal and page share, one screen, one page."""
