"""Who may see and do what on the page: users, log-ins, attempts, and what guards every request."""
