# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# A page with each block between `<!-- made: NAME -->` and `<!-- end -->` replaced by the file NAME in
# `folder`; a block without a file stays as it is, and is named on standard error.
/^<!-- made: / {
    print
    file = folder "/" $3
    skipping = 0
    while ((getline line < file) > 0) {
        print line
        skipping = 1
    }
    if (!skipping)
        print "not measured: " $3 > "/dev/stderr"
    close(file)
    next
}
/^<!-- end -->/ { skipping = 0 }
!skipping { print }
