"""What to do about a file that cannot be read, by the reason that the system gives."""


def reading_advice(error: OSError, otherwise: str) -> str:
    """End of a sentence that names the file and says what the system said.

    Parameters
    ----------
    error : OSError
    otherwise : str
        Advice where the file is neither kept from this user nor a folder.
    """
    if isinstance(error, PermissionError):
        return "let this user read it"
    return "give a file, not a folder" if isinstance(error, IsADirectoryError) else otherwise
