/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * From a stream to the nodes of its YAML document.
 */
#include "text/yaml_document.h"

#include <stdarg.h>
#include <string.h>

__attribute__((format(printf, 3, 4))) static int refuse(tfa_yaml_fault *fault, yaml_mark_t mark,
                                                        const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fault->mark = mark;
    vsnprintf(fault->text, sizeof fault->text, format, arguments);
    va_end(arguments);
    return TFA_E_PARSE;
}

static int refuse_yaml(const yaml_parser_t *parser, tfa_yaml_fault *fault)
{
    if (parser->error == YAML_MEMORY_ERROR)
        return TFA_E_MEMORY;
    const bool tab = parser->problem && strstr(parser->problem, "cannot start any token");
    return refuse(fault, parser->error == YAML_READER_ERROR ? parser->mark : parser->problem_mark,
                  "this is not YAML: %s%s%s%s", parser->problem ? parser->problem : "unreadable",
                  parser->context ? " " : "", parser->context ? parser->context : "",
                  tab ? "; indent by spaces, quote texts that begin with a special character" : "");
}

/* One file is one document. */
static int check_end(yaml_parser_t *parser, tfa_yaml_fault *fault)
{
    yaml_document_t more;
    if (!yaml_parser_load(parser, &more))
        return refuse_yaml(parser, fault);
    const yaml_node_t *root = yaml_document_get_root_node(&more);
    const int status =
        root ? refuse(fault, root->start_mark, "a second document; a file is one document")
             : TFA_OK;
    yaml_document_delete(&more);
    return status;
}

static int parse_document(yaml_parser_t *parser, yaml_document_t *document, tfa_yaml_fault *fault)
{
    if (!yaml_parser_load(parser, document))
        return refuse_yaml(parser, fault);
    const int status = yaml_document_get_root_node(document)
                           ? check_end(parser, fault)
                           : refuse(fault, (yaml_mark_t){0}, "no keys; the file is empty");
    if (status != TFA_OK)
        yaml_document_delete(document);
    return status;
}

static bool has_anchor(const yaml_event_t *event)
{
    return event->type == YAML_ALIAS_EVENT ||
           (event->type == YAML_SCALAR_EVENT && event->data.scalar.anchor) ||
           (event->type == YAML_SEQUENCE_START_EVENT && event->data.sequence_start.anchor) ||
           (event->type == YAML_MAPPING_START_EVENT && event->data.mapping_start.anchor);
}

/* libyaml takes a time that grows with the square of the depth and of the number of anchors. Errors
 * of another kind are left to the reading that follows. */
static int check_events(yaml_parser_t *parser, int depth_max, bool aliases, tfa_yaml_fault *fault)
{
    yaml_event_t event;
    int depth = 0, status = TFA_OK;
    bool more = true;
    while (more && status == TFA_OK && yaml_parser_parse(parser, &event)) {
        more = event.type != YAML_STREAM_END_EVENT;
        depth += event.type == YAML_SEQUENCE_START_EVENT || event.type == YAML_MAPPING_START_EVENT;
        depth -= event.type == YAML_SEQUENCE_END_EVENT || event.type == YAML_MAPPING_END_EVENT;
        if (depth > depth_max)
            status =
                refuse(fault, event.start_mark,
                       "lists and keys within each other, more than %d levels deep", depth_max);
        else if (!aliases && has_anchor(&event))
            status = refuse(fault, event.start_mark,
                            "anchors (&) and aliases (*) are not read here; write the values out");
        yaml_event_delete(&event);
    }
    return status;
}

int tfa_yaml_read(FILE *stream, int depth_max, bool aliases, yaml_document_t *document,
                  tfa_yaml_fault *fault)
{
    int status = TFA_OK;
    for (int pass = 0; pass < 2 && status == TFA_OK; pass++) {
        yaml_parser_t parser;
        if (!yaml_parser_initialize(&parser))
            return TFA_E_MEMORY;
        rewind(stream);
        yaml_parser_set_input_file(&parser, stream);
        status = pass == 0 ? check_events(&parser, depth_max, aliases, fault)
                           : parse_document(&parser, document, fault);
        yaml_parser_delete(&parser);
    }
    return status;
}
