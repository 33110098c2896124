"""Who may do what: roles, addresses that may write, certificates, and what is logged of those who may not."""
