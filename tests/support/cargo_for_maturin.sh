#!/bin/sh
# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
# Cargo for maturin in the tests: builds the Python module together with the crate of the tests. Both then have the same features of their
# dependencies, which the tests have compiled already.
[ "$1" = rustc ] || exec cargo "$@"
exec cargo build --lib -p camwright_nodes -p camwright_python --message-format json-render-diagnostics
