"""The protocol: every message between page and server, as JSON over one WebSocket at the path /ws.

The server greets with `{"hello": Hello}`. A page then sends requests; `do` has their name. Every
answer has the id of its request, and comes in one or more parts, each with some of its fields.
`error`, `progress` and `overtaken` come alone.

The protocol's reference, its JSON Schema and the page's `protocol.ts` are generated from here.
"""
