# SPDX-License-Identifier: Apache-2.0
"""What builds, proves, measures and publishes the repository of ``wavehaptics``.

It is no part of the installed package, which never imports it. It needs a checkout.
"""
