# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Commands of `totalforce` that draw, iterate or compare, over the module totalforce.

command  command lines, exit statuses, files of rows
cases    robots and states to measure methods on, with exact answers
scene    options that say how a URDF becomes a model
style    how pictures look
page     an HTML page around pictures
CMD      `totalforce CMD`: main(argv) returns an exit status; CMD_PART are its parts
"""
