"""A small private authority for one mill: its certificates for the gauge and for the clients.

Keys are ECDSA on P-256, which every implementation of TLS 1.2 of the last ten years has. The authority's key is needed
only to make certificates: it can be kept away from the gauge.
"""

import contextlib
import ipaddress
import os
from collections.abc import Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.serialization import (
    Encoding,
    NoEncryption,
    PrivateFormat,
    load_pem_private_key,
)
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from plc.security.identity import ROLE_OID, CertificateError
from plc.security.roles import Role

AUTHORITY_DAYS = 7300
CERTIFICATE_DAYS = 1095
_CLOCKS_APART = timedelta(days=1)  # a PLC's clock may be behind


class Authority:
    """An authority that signs certificates.

    Parameters
    ----------
    certificate : x509.Certificate
    key : EllipticCurvePrivateKey
    """

    def __init__(self, certificate: x509.Certificate, key: ec.EllipticCurvePrivateKey) -> None:
        self._certificate = certificate
        self._key = key

    @classmethod
    def make(cls, days: float = AUTHORITY_DAYS) -> "Authority":
        """A new authority with a key of its own, valid for some days from now."""
        key = ec.generate_private_key(ec.SECP256R1())
        name = _name(f"Hotgauge authority {datetime.now(UTC):%Y-%m-%d}")
        limits = x509.BasicConstraints(ca=True, path_length=0)
        builder = _builder(name, name, key.public_key(), days).add_extension(limits, critical=True)
        builder = builder.add_extension(_usage(signs_certificates=True), critical=True)
        builder = builder.add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
        return cls(builder.sign(key, SHA256()), key)

    @classmethod
    def load(cls, folder: Path) -> "Authority":
        """The authority that `save` has written.

        Raises
        ------
        CertificateError
            The files are not there, or not an authority.
        """
        try:
            certificate = x509.load_pem_x509_certificate((folder / "authority.pem").read_bytes())
            key = load_pem_private_key((folder / "authority.key").read_bytes(), None)
        except OSError as error:
            raise CertificateError(
                f"{error.filename}: {os.strerror(error.errno or 0)}; give the folder of the authority"
            ) from error
        except (ValueError, TypeError) as error:
            raise CertificateError(f"{folder}: authority.pem and authority.key cannot be read ({error})") from error
        if not isinstance(key, ec.EllipticCurvePrivateKey) or key.public_key() != certificate.public_key():
            raise CertificateError(f"{folder}: authority.key is not the key of authority.pem")
        return cls(certificate, key)

    def save(self, folder: Path) -> list[Path]:
        """Write `authority.pem` and `authority.key`; raises OSError."""
        return _write(folder, "authority", self._certificate, self._key)

    def server(self, folder: Path, hosts: Sequence[str], days: float = CERTIFICATE_DAYS) -> list[Path]:
        """Write `server.pem` and `server.key` of a gauge; they replace those that are there.

        Parameters
        ----------
        folder : Path
        hosts : sequence of str
            Names and addresses by which clients know it.
        days : float
            How long it is valid.

        Returns
        -------
        list of Path
            Files written.

        Raises
        ------
        OSError
            The folder cannot be written.
        """
        names = x509.SubjectAlternativeName([_alternative(host) for host in hosts])
        certificate, key = self._sign(hosts[0], days, ExtendedKeyUsageOID.SERVER_AUTH, names)
        return _write(folder, "server", certificate, key)

    def client(self, folder: Path, name: str, role: Role, days: float = CERTIFICATE_DAYS) -> list[Path]:
        """Write `client-NAME.pem` and `client-NAME.key`; they replace those that are there.

        Parameters
        ----------
        folder : Path
        name : str
            Common name of the certificate.
        role : Role
        days : float
            How long it is valid.

        Returns
        -------
        list of Path
            Files written.

        Raises
        ------
        OSError
            The folder cannot be written.
        """
        text = role.encode("utf-8")
        value = x509.UnrecognizedExtension(ROLE_OID, bytes((0x0C, len(text))) + text)  # a UTF8String of ASN.1
        certificate, key = self._sign(name, days, ExtendedKeyUsageOID.CLIENT_AUTH, value)
        return _write(folder, f"client-{name}", certificate, key)

    def _sign(
        self, name: str, days: float, purpose: x509.ObjectIdentifier, extension: x509.ExtensionType
    ) -> tuple[x509.Certificate, ec.EllipticCurvePrivateKey]:
        key = ec.generate_private_key(ec.SECP256R1())
        signer = x509.AuthorityKeyIdentifier.from_issuer_public_key(self._key.public_key())
        builder = _builder(_name(name), self._certificate.subject, key.public_key(), days)
        builder = builder.add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        builder = builder.add_extension(_usage(signs_certificates=False), critical=True)
        builder = builder.add_extension(x509.ExtendedKeyUsage([purpose]), critical=False)
        builder = builder.add_extension(signer, critical=False).add_extension(extension, critical=False)
        return builder.sign(self._key, SHA256()), key


def _name(common: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, common)])


def _builder(
    subject: x509.Name, issuer: x509.Name, key: ec.EllipticCurvePublicKey, days: float
) -> x509.CertificateBuilder:
    now = datetime.now(UTC)
    end = now + timedelta(days=days)
    begin = min(now - _CLOCKS_APART, end - _CLOCKS_APART)
    builder = x509.CertificateBuilder(subject_name=subject, issuer_name=issuer, public_key=key)
    return builder.serial_number(x509.random_serial_number()).not_valid_before(begin).not_valid_after(end)


def _usage(*, signs_certificates: bool) -> x509.KeyUsage:
    return x509.KeyUsage(
        digital_signature=not signs_certificates,
        content_commitment=False,
        key_encipherment=False,
        data_encipherment=False,
        key_agreement=False,
        key_cert_sign=signs_certificates,
        crl_sign=signs_certificates,
        encipher_only=False,
        decipher_only=False,
    )


def _alternative(host: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(host))
    except ValueError:
        return x509.DNSName(host)


def _write(folder: Path, name: str, certificate: x509.Certificate, key: ec.EllipticCurvePrivateKey) -> list[Path]:
    """Write a certificate and its key, each replaced whole, the key readable by its owner only."""
    folder.mkdir(parents=True, exist_ok=True)
    key_text = key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
    files = [folder / f"{name}.pem", folder / f"{name}.key"]
    for file, text, mode in zip(files, (certificate.public_bytes(Encoding.PEM), key_text), (0o644, 0o600), strict=True):
        new = file.with_name(f"{file.name}.new")
        with contextlib.suppress(FileNotFoundError):
            new.unlink()
        with os.fdopen(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "wb") as target:
            target.write(text)
            target.flush()
            os.fsync(target.fileno())
        new.replace(file)
    return files
