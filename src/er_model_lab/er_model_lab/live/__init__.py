"""The running graph as the page sees it: what is heard of it, what that does not show yet, and who listens."""
