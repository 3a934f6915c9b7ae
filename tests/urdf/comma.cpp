/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A C++ locale with a decimal comma, made here so that no such locale has to be installed.
 */
#include "comma.h"

#include <locale>
#include <sstream>

namespace
{

class comma : public std::numpunct<char>
{
  protected:
    char do_decimal_point() const override
    {
        return ',';
    }
    char do_thousands_sep() const override
    {
        return '.';
    }
    std::string do_grouping() const override
    {
        return "\3";
    }
};

} // namespace

void comma_set(bool on)
{
    std::locale classic = std::locale::classic();
    std::locale::global(on ? std::locale(classic, new comma) : classic); /* the locale owns it */
}

bool comma_is_set(void)
{
    std::ostringstream out;
    out << 1.5;
    return out.str() == "1,5";
}
