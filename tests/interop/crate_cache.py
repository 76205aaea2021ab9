"""Puts the context of RO-Crate 1.2, as npm's ro-crate brings it, into the cache of roc-validator, which then needs no network.

    crate_cache.py CONTEXT.json CACHE
"""

import io
import sys
from pathlib import Path

import requests
from requests_cache import CachedSession
from urllib3 import HTTPResponse

URL = "https://w3id.org/ro/crate/1.2/context"


class OneFile(requests.adapters.HTTPAdapter):
    """Answers every request with one file."""

    def __init__(self, content):
        super().__init__()
        self.content = content

    def send(self, request, **_):
        headers = {"Content-Type": "application/ld+json"}
        body = HTTPResponse(body=io.BytesIO(self.content), status=200, headers=headers, preload_content=False)
        return self.build_response(request, body)


context, cache = sys.argv[1:]
session = CachedSession(cache_name=cache, expire_after=-1)
session.mount("https://", OneFile(Path(context).read_bytes()))
session.get(URL, headers={"Accept": "application/ld+json, application/json, */*;q=0.1"})
