"""Who may ask: a request needs the token in its address, the host of this page, and no foreign origin."""

import hmac
from email.message import Message
from http import HTTPStatus
from typing import NamedTuple
from urllib.parse import parse_qsl, urlsplit

HOSTS = ("127.0.0.1", "localhost")
"""Names under which a browser on this machine reaches the page."""
MOST_BODY = 2**18
"""Longest body of a request [bytes]."""
MOST_FIELDS = 20
"""Most fields of the query of an address [1]."""
SAME_SITE = ("same-origin", "none")
"""What a browser reports of requests that come from the page itself, or from its address line."""


class Refusal(NamedTuple):
    """Why a request is not answered."""

    status: HTTPStatus
    """Status of HTTP."""
    why: str
    """Message."""


class Guard(NamedTuple):
    """What admits a request."""

    port: int
    """Port of the page."""
    token: str
    """Secret part of its address."""

    def refusal(self, method: str, target: str, headers: Message) -> Refusal | None:
        """Return why a request is refused, or None for one that is answered.

        Parameters
        ----------
        method : ``GET`` or ``POST``
        target : its path and query
        headers : its headers
        """
        hosts = [f"{host}:{self.port}" for host in HOSTS]
        if headers.get("Host", "") not in hosts:
            return Refusal(HTTPStatus.FORBIDDEN, "the host of the request is not this page")
        origin = headers.get("Origin")
        if origin is not None and origin not in [f"http://{host}" for host in hosts]:
            return Refusal(HTTPStatus.FORBIDDEN, "the request comes from another page")
        if headers.get("Sec-Fetch-Site", "none") not in SAME_SITE:
            return Refusal(HTTPStatus.FORBIDDEN, "the request comes from another page")
        try:
            path = urlsplit(target).path
            parse_qsl(urlsplit(target).query, max_num_fields=MOST_FIELDS)
        except ValueError:
            return Refusal(HTTPStatus.BAD_REQUEST, "the address cannot be read")
        given = path.lstrip("/").partition("/")[0].encode()
        if not hmac.compare_digest(given, self.token.encode()):
            return Refusal(HTTPStatus.FORBIDDEN, "the token in the address is wrong")
        return self._refused_body(headers) if method == "POST" else None

    @staticmethod
    def _refused_body(headers: Message) -> Refusal | None:
        """Return why the body of a request is not read, or None."""
        length = headers.get("Content-Length", "")
        if "Transfer-Encoding" in headers or not (length.isascii() and length.isdigit()):
            return Refusal(HTTPStatus.LENGTH_REQUIRED, "the length of the body must be given")
        if len(length) > 9 or int(length) > MOST_BODY:
            return Refusal(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"the body is longer than {MOST_BODY} bytes")
        if headers.get("Content-Type", "").partition(";")[0].strip() != "application/json":
            return Refusal(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "the body must be JSON")
        return None
