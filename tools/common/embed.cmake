# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Writes files as arrays of characters, ended by a zero:
#   cmake -DOUT=x.c -DNAMES="a;b" -DFILES="a.css;b.js" -P embed.cmake
file(WRITE ${OUT}.part "/* made by tools/common/embed.cmake */\n")
foreach(name file IN ZIP_LISTS NAMES FILES)
  file(READ ${file} bytes HEX)
  string(REGEX REPLACE "(..)" "0x\\1," bytes "${bytes}")
  string(REGEX REPLACE "(................................................................................)"
    "\\1\n" bytes "${bytes}")
  file(APPEND ${OUT}.part "extern const char ${name}[];\nconst char ${name}[] = {\n${bytes}0};\n")
endforeach()
file(RENAME ${OUT}.part ${OUT})
