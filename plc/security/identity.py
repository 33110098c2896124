"""The gauge's certificate, and those of its clients, after the MODBUS/TCP Security Protocol Specification."""

import hashlib
import os
import ssl
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from cryptography import x509
from cryptography.x509.oid import NameOID

from plc.security.roles import Role

ROLE_OID = x509.ObjectIdentifier("1.3.6.1.4.1.50316.802.1")
NAME_LENGTH_MAX = 64  # ub-common-name of RFC 5280
_UTF8_STRING = 0x0C  # tag in the encoding of ASN.1


class CertificateError(Exception):
    """Files of certificates cannot be used; the message says which setting, why and what to do."""


class TlsFiles(NamedTuple):
    """Files in PEM: the gauge's certificate, its key without a password, and the authority of its clients."""

    certificate: Path
    key: Path
    authority: Path


@dataclass(frozen=True, slots=True)
class Identity:
    """What the secure port shows and whom it trusts.

    Attributes
    ----------
    context : SSLContext
        Asks every client for a certificate of the authority; TLS 1.2 or newer.
    expires : datetime
        When the first of the gauge's certificate and the authority's ends.
    state : tuple of int
        Changes when one of the files does.
    authority_digest : bytes
        Changes when other clients are trusted.
    """

    context: ssl.SSLContext
    expires: datetime
    state: tuple[int, ...]
    authority_digest: bytes

    @classmethod
    def load(cls, files: TlsFiles) -> "Identity":
        """Read the files.

        Raises
        ------
        CertificateError
            A file is missing, cannot be read or is not what it should be, or key and certificate are no pair.
        """
        state = files_state(files)
        certificates = [*_read(files.certificate, "certificate"), *_read(files.authority, "authority")]
        return cls(
            context=_context(files),
            expires=min(certificate.not_valid_after_utc for certificate in certificates),
            state=state,
            authority_digest=hashlib.sha256(files.authority.read_bytes()).digest(),
        )


def files_state(files: TlsFiles) -> tuple[int, ...]:
    """Number that changes when one of the files does; 0 for one that cannot be seen."""
    return tuple(number for file in files for number in _file_state(file))


def _file_state(file: Path) -> tuple[int, int, int]:
    try:
        found = file.stat()
    except OSError:
        return 0, 0, 0
    return found.st_ino, found.st_mtime_ns, found.st_size


def _read(file: Path, setting: str) -> Iterable[x509.Certificate]:
    try:
        return x509.load_pem_x509_certificates(file.read_bytes())
    except OSError as error:
        raise _unusable(file, setting, os.strerror(error.errno or 0)) from error
    except ValueError as error:
        raise _unusable(file, setting, "it holds no certificate in PEM") from error


def _unusable(file: Path, setting: str, why: str) -> CertificateError:
    remedy = "make the files with hotgauge certificates and let the gauge's user read them"
    return CertificateError(f"plc.tls.{setting}: {file}: {why}; {remedy}")


def _no_password() -> str:
    raise ValueError


def _context(files: TlsFiles) -> ssl.SSLContext:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    # a client shows its certificate with every connection: one that has expired is not let in by a ticket
    context.options |= ssl.OP_NO_TICKET | ssl.OP_NO_RENEGOTIATION
    context.num_tickets = 0
    context.verify_mode = ssl.CERT_REQUIRED
    try:
        context.load_verify_locations(files.authority)
    except (OSError, ssl.SSLError) as error:
        raise _unusable(files.authority, "authority", "it is no certificate of an authority") from error
    try:
        context.load_cert_chain(files.certificate, files.key, password=_no_password)
    except ssl.SSLError as error:
        raise _unusable(files.key, "key", "it is not the key of plc.tls.certificate") from error
    except ValueError as error:
        raise _unusable(files.key, "key", "a password locks it, which nobody types in at a start") from error
    except OSError as error:
        raise _unusable(files.key, "key", os.strerror(error.errno or 0)) from error
    return context


class Holder(NamedTuple):
    """Who a client's certificate says that it is; `role` is None without one that is known."""

    name: str
    role: Role | None


def holder(certificate: bytes) -> Holder:
    """Name and role in a client's certificate, which the authority has signed.

    Parameters
    ----------
    certificate : bytes
        DER, as `SSLObject.getpeercert` gives it.

    Raises
    ------
    CertificateError
        It has expired, or cannot be read.
    """
    try:
        read = x509.load_der_x509_certificate(certificate)
        names = read.subject.get_attributes_for_oid(NameOID.COMMON_NAME)
        extensions = [extension for extension in read.extensions if extension.oid == ROLE_OID]
    except ValueError as error:
        raise CertificateError(f"its certificate cannot be read ({error})") from error
    if read.not_valid_after_utc < datetime.now(UTC):
        raise CertificateError("its certificate has expired")
    name = "".join(char for char in str(names[0].value) if char.isprintable()) if names else ""
    return Holder(name[:NAME_LENGTH_MAX] or "without a name", _role(extensions[0].value) if extensions else None)


def _role(extension: x509.ExtensionType) -> Role | None:
    """Role in an extension; its value is a UTF8String of ASN.1."""
    value = extension.public_bytes()
    if len(value) < 2 or value[0] != _UTF8_STRING or value[1] != len(value) - 2:
        return None
    try:
        return Role(value[2:].decode("utf-8"))
    except ValueError:
        return None
