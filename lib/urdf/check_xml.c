/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Linear check of the bytes of a URDF file before a parser reads them.
 *
 * TinyXML recurses into elements, reads past the end after a cut UTF-8 sequence, accepts unbalanced
 * quotes in attribute values, and accepts text that is not XML. This pass matches every tag against
 * the XML grammar and copies tags, and the text of <mechanicalReduction>; comments, declarations,
 * CDATA and other text become blanks.
 */
#include "urdf/urdf.h"

#include <stdbool.h>
#include <string.h>

typedef struct xml_scanner {
    const char *text;
    size_t length;
    size_t at;     /* next byte */
    uint32_t line; /* of that byte */
    char *clean;
    size_t nodes;
    size_t roots;
    size_t depth;
    struct {
        const char *name;
        int length;
        uint32_t line;
    } open[TFA_URDF_MAX_DEPTH];
    tfa_urdf_log *log;
} xml_scanner;

/* Reports an error at the present line; false. */
#define XML_ERROR(g, code, ...)                                                                    \
    (tfa_urdf_report((g)->log, TFA_ERROR, (g)->line, code, "xml: " __VA_ARGS__), false)
#define BAD_XML(g, ...) XML_ERROR(g, "bad-xml", __VA_ARGS__)

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

const char *tfa_urdf_strip(const char *text, size_t *length)
{
    while (is_blank(*text))
        text++;
    *length = strlen(text);
    while (*length > 0 && is_blank(text[*length - 1]))
        --*length;
    return text;
}

static bool is_name_start(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

static bool is_name_byte(char c)
{
    return is_name_start(c) || (c >= '0' && c <= '9') || c == '-' || c == '.' || c == ':';
}

static bool starts_with(const xml_scanner *g, const char *word)
{
    size_t n = strlen(word);
    return g->length - g->at >= n && memcmp(g->text + g->at, word, n) == 0;
}

static void advance(xml_scanner *g, size_t count)
{
    for (size_t end = g->at + count; g->at < end; g->at++) {
        char c = g->text[g->at];
        bool before_newline = g->at + 1 < g->length && g->text[g->at + 1] == '\n';
        g->line += c == '\n' || (c == '\r' && !before_newline);
    }
}

static void skip_blanks(xml_scanner *g)
{
    while (g->at < g->length && is_blank(g->text[g->at]))
        advance(g, 1);
}

static int skip_name(xml_scanner *g)
{
    size_t start = g->at;
    if (g->at < g->length && is_name_start(g->text[g->at]))
        while (g->at < g->length && g->at - start < 1000 && is_name_byte(g->text[g->at]))
            g->at++;
    return (int)(g->at - start);
}

/* Bytes of the well-formed UTF-8 sequence at p, 0 if there is none. */
static size_t utf8_length(const unsigned char *p, size_t remaining)
{
    if (p[0] < 0x80)
        return 1;
    size_t n = p[0] >= 0xC2 && p[0] < 0xE0 ? 2 : (p[0] & 0xF0) == 0xE0 ? 3 : p[0] < 0xF0 ? 0 : 4;
    if (n == 0 || p[0] > 0xF4 || remaining < n)
        return 0;
    for (size_t i = 1; i < n; i++)
        if ((p[i] & 0xC0) != 0x80)
            return 0;
    bool overlong = (p[0] == 0xE0 && p[1] < 0xA0) || (p[0] == 0xF0 && p[1] < 0x90);
    bool beyond = (p[0] == 0xED && p[1] > 0x9F) || (p[0] == 0xF4 && p[1] > 0x8F);
    return overlong || beyond ? 0 : n;
}

static int digit_value(char c, unsigned base)
{
    int value = c >= '0' && c <= '9'   ? c - '0'
                : c >= 'a' && c <= 'f' ? c - 'a' + 10
                : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                       : 99;
    return value < (int)base ? value : -1;
}

/* Length of the character reference "&#...;" at this position, 0 if it names no character. */
static size_t reference_length(const xml_scanner *g)
{
    const char *p = g->text + g->at;
    size_t remaining = g->length - g->at;
    unsigned base = remaining > 2 && p[2] == 'x' ? 16 : 10;
    size_t start = base == 16 ? 3 : 2;
    size_t i = start;
    uint32_t value = 0;
    for (; i < remaining && i < 12 && digit_value(p[i], base) >= 0; i++)
        value = value > 0x10FFFF ? value : value * base + (uint32_t)digit_value(p[i], base);
    bool surrogate = value >= 0xD800 && value <= 0xDFFF;
    if (i == start || i >= remaining || p[i] != ';' || value == 0 || value > 0x10FFFF || surrogate)
        return 0;
    return i + 1;
}

/* One character inside an attribute value. */
static bool scan_value_character(xml_scanner *g)
{
    unsigned char c = (unsigned char)g->text[g->at];
    size_t n = utf8_length((const unsigned char *)g->text + g->at, g->length - g->at);
    if (n == 0)
        return XML_ERROR(g, "bad-encoding", "byte 0x%02x is not UTF-8; save the file as UTF-8", c);
    if (c == '<')
        return BAD_XML(
            g, "'<' inside an attribute value; close the value with its quote, or write &lt;");
    if (c < 0x20 && !is_blank((char)c))
        return BAD_XML(g, "control character 0x%02x; remove it", c);
    if (starts_with(g, "&#")) {
        n = reference_length(g);
        if (n == 0)
            return BAD_XML(
                g, "'&#' without a valid character number and ';'; write the character itself");
    }
    advance(g, n);
    return true;
}

static bool scan_attribute(xml_scanner *g, const char *name, int length)
{
    if (length == 0)
        return BAD_XML(g, "expected an attribute or '>'; close the tag");
    skip_blanks(g);
    if (g->at >= g->length || g->text[g->at] != '=')
        return BAD_XML(g, "attribute '%.*s' has no value; write %.*s=\"...\"", length, name, length,
                       name);
    advance(g, 1);
    skip_blanks(g);
    char quote = g->at < g->length ? g->text[g->at] : '\0';
    if (quote != '"' && quote != '\'')
        return BAD_XML(g, "the value of '%.*s' is not quoted; write %.*s=\"...\"", length, name,
                       length, name);
    advance(g, 1);
    while (g->at < g->length && g->text[g->at] != quote)
        if (!scan_value_character(g))
            return false;
    if (g->at >= g->length)
        return BAD_XML(g, "the value of '%.*s' never ends; close its quote", length, name);
    advance(g, 1);
    return true;
}

static bool scan_attributes(xml_scanner *g)
{
    struct {
        const char *name;
        int length;
    } seen[TFA_URDF_MAX_ATTRIBUTES];
    for (size_t count = 0;; count++) {
        skip_blanks(g);
        if (g->at >= g->length)
            return BAD_XML(g, "the file ends inside a tag; is it complete?");
        if (g->text[g->at] == '>' || starts_with(g, "/>"))
            return true;
        if (count >= TFA_URDF_MAX_ATTRIBUTES || ++g->nodes > TFA_URDF_MAX_NODES)
            return XML_ERROR(g, "too-large", "too many attributes; split the file");
        const char *name = g->text + g->at;
        int length = skip_name(g);
        for (size_t i = 0; i < count && length > 0; i++)
            if (seen[i].length == length && memcmp(seen[i].name, name, (size_t)length) == 0)
                return BAD_XML(g, "attribute '%.*s' stands twice in a tag; remove one", length,
                               name);
        seen[count].name = name;
        seen[count].length = length;
        if (!scan_attribute(g, name, length))
            return false;
    }
}

static bool scan_start_tag(xml_scanner *g)
{
    uint32_t line = g->line;
    advance(g, 1);
    const char *name = g->text + g->at;
    int length = skip_name(g);
    if (length == 0)
        return BAD_XML(g, "'<' is not followed by a name; write &lt; in text");
    if (g->depth == 0 && g->roots++ > 0)
        return BAD_XML(g, "a second root element <%.*s>; a file holds one robot", length, name);
    if (g->depth >= TFA_URDF_MAX_DEPTH)
        return XML_ERROR(g, "too-deep",
                         "more than %d elements inside one another; flatten the file",
                         TFA_URDF_MAX_DEPTH);
    if (++g->nodes > TFA_URDF_MAX_NODES)
        return XML_ERROR(g, "too-large", "more than %d elements and attributes; split the file",
                         TFA_URDF_MAX_NODES);
    if (!scan_attributes(g))
        return false;
    if (g->text[g->at] == '/') {
        advance(g, 2);
        return true;
    }
    advance(g, 1);
    g->open[g->depth].name = name;
    g->open[g->depth].length = length;
    g->open[g->depth++].line = line;
    return true;
}

static bool scan_end_tag(xml_scanner *g)
{
    advance(g, 2);
    const char *name = g->text + g->at;
    int length = skip_name(g);
    skip_blanks(g);
    if (length == 0 || g->at >= g->length || g->text[g->at] != '>')
        return BAD_XML(g, "an end tag needs a name and '>'; complete it");
    if (g->depth == 0)
        return BAD_XML(g, "</%.*s> closes nothing; remove it", length, name);
    g->depth--;
    if (length != g->open[g->depth].length ||
        memcmp(name, g->open[g->depth].name, (size_t)length) != 0)
        return BAD_XML(g, "</%.*s> where </%.*s> should close line %u; correct one", length, name,
                       g->open[g->depth].length, g->open[g->depth].name, g->open[g->depth].line);
    advance(g, 1);
    return true;
}

/* Skips a comment, CDATA section or declaration up to and including `end`. */
static bool skip_until(xml_scanner *g, size_t opening, const char *end, const char *what)
{
    size_t start = g->at + opening;
    const char *found =
        start < g->length ? memmem(g->text + start, g->length - start, end, strlen(end)) : NULL;
    if (!found)
        return BAD_XML(g, "a %s never ends; close it with %s", what, end);
    size_t stop = (size_t)(found - g->text);
    if (end[0] == '>' && memchr(g->text + g->at, '[', stop - g->at))
        return BAD_XML(g, "a document type with declarations is not supported; remove it");
    advance(g, stop + strlen(end) - g->at);
    return true;
}

static bool scan_markup(xml_scanner *g)
{
    if (starts_with(g, "<!--"))
        return skip_until(g, 4, "-->", "comment");
    if (starts_with(g, "<![CDATA["))
        return skip_until(g, 9, "]]>", "CDATA section");
    if (starts_with(g, "<?"))
        return skip_until(g, 2, "?>", "declaration");
    if (starts_with(g, "<!"))
        return skip_until(g, 2, ">", "document type");
    size_t start = g->at;
    if (!(starts_with(g, "</") ? scan_end_tag(g) : scan_start_tag(g)))
        return false;
    memcpy(g->clean + start, g->text + start, g->at - start);
    return true;
}

static bool is_reduction(const xml_scanner *g)
{
    static const char name[] = "mechanicalReduction";
    const size_t length = g->depth > 0 ? (size_t)g->open[g->depth - 1].length : 0;
    return length == sizeof name - 1 && memcmp(g->open[g->depth - 1].name, name, length) == 0;
}

/* Copies a byte of a text that is to be a number: what cannot be part of one becomes a '?'. */
static void keep_number_byte(xml_scanner *g, char c)
{
    g->clean[g->at] = is_blank(c) ? c : c > ' ' && c <= '~' && c != '&' ? c : '?';
}

static bool scan_content(xml_scanner *g)
{
    while (g->at < g->length) {
        char c = g->text[g->at];
        if (c == '<') {
            if (!scan_markup(g))
                return false;
            continue;
        }
        if (g->depth == 0 && !is_blank(c))
            return BAD_XML(g, "text outside the root element; is this a URDF file?");
        if (is_reduction(g))
            keep_number_byte(g, c);
        advance(g, 1);
    }
    return true;
}

static bool check_end(xml_scanner *g)
{
    if (g->depth > 0) {
        g->depth--;
        return BAD_XML(g, "<%.*s> of line %u is never closed; is the file complete?",
                       g->open[g->depth].length, g->open[g->depth].name, g->open[g->depth].line);
    }
    if (g->roots == 0)
        return XML_ERROR(g, "empty-file", "no element at all; a URDF file holds a <robot>");
    return true;
}

int tfa_urdf_check_xml(const char *text, size_t length, char *clean, tfa_urdf_log *log)
{
    xml_scanner g = {.text = text, .length = length, .line = 1, .clean = clean, .log = log};
    const char *nul = length > 0 ? memchr(text, '\0', length) : NULL;
    if (nul) {
        advance(&g, (size_t)(nul - text));
        (void)XML_ERROR(&g, "bad-encoding",
                        "a NUL byte; this is no text file, or not UTF-8: save it as UTF-8");
        return TFA_E_PARSE;
    }
    for (size_t i = 0; i < length; i++)
        clean[i] = text[i] == '\n' || text[i] == '\r' ? text[i] : ' ';
    clean[length] = '\0';
    if (starts_with(&g, "\xEF\xBB\xBF"))
        g.at = 3;
    return scan_content(&g) && check_end(&g) ? TFA_OK : TFA_E_PARSE;
}
