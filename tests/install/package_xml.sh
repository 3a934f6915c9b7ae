# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# package.xml by the rules of REP 149, format 3: elements, their number, order of none, and content;
# the version is that of CMake; it is installed, with ament's marker.
#
#   sh tests/install/package_xml.sh SOURCE_FOLDER BUILD_FOLDER
set -eu
xml=$1/package.xml
build=$2
failures=0
fail() {
    echo "FAILED: $*"
    failures=$((failures + 1))
}
value() {
    xmllint --xpath "string($1)" "$xml"
}
# count XPATH LOW HIGH
count() {
    n=$(xmllint --xpath "count($1)" "$xml")
    if [ "$n" -lt "$2" ] || [ "$n" -gt "$3" ]; then
        fail "$n times $1, not $2 to $3"
    fi
}
xmllint --noout "$xml" || fail "not well-formed"
[ "$(value /package/@format)" = 3 ] || fail "format is not 3"
count /package 1 1
for element in name version description; do
    count "/package/$element" 1 1
done
count /package/maintainer 1 99
count '/package/maintainer[not(contains(@email, "@"))]' 0 0
count /package/license 1 99
count /package/license/@file 0 1
count /package/export/build_type 1 1
expr "$(value /package/name)" : '[a-z][a-z0-9_]*$' >/dev/null || fail "name"
expr "$(value /package/version)" : '[0-9]*\.[0-9]*\.[0-9]*$' >/dev/null || fail "version"
[ "$(value /package/export/build_type)" = cmake ] || fail "build_type"
[ -e "$1/$(value /package/license/@file)" ] || fail "the licence's file"
known='self::name or self::version or self::description or self::maintainer or self::license or
    self::url or self::author or self::depend or self::build_depend or self::build_export_depend or
    self::buildtool_depend or self::buildtool_export_depend or self::exec_depend or
    self::test_depend or self::doc_depend or self::conflict or self::replace or
    self::group_depend or self::member_of_group or self::export'
count "/package/*[not($known)]" 0 0
count '//*[contains(local-name(), "depend")][normalize-space() = ""]' 0 0
# a dependency is named once for each purpose
twice=$(grep -o '<[a-z_]*depend>[^<]*' "$xml" | sed 's/.*>//' | sort | uniq -d)
[ -z "$twice" ] || fail "named twice: $twice"

version=$(sed -n 's/^CMAKE_PROJECT_VERSION:STATIC=//p' "$build/CMakeCache.txt")
[ "$(value /package/version)" = "$version" ] || fail "the version is not CMake's, $version"
[ "$(sed -n '1s/.*(\([^-]*\)-.*/\1/p' "$1/debian/changelog")" = "$version" ] ||
    fail "the version of debian/changelog is not CMake's"
prefix=$(mktemp -d)
trap 'rm -rf "$prefix"' EXIT
cmake --install "$build" --prefix "$prefix" >/dev/null
cmp "$xml" "$prefix/share/totalforce/package.xml" || fail "share/totalforce/package.xml"
[ -f "$prefix/share/ament_index/resource_index/packages/totalforce" ] || fail "ament's marker"
[ "$failures" -eq 0 ] && echo "all good"
exit $((failures > 0))
