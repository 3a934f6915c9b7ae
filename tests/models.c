/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 */
#include "models.h"
#include "test.h"

static void must(int status, const char *what, tfa_report *report)
{
    if (status != TFA_OK)
        fail_msg("%s: %s: %s", what, tfa_status_text(status),
                 report && report->count ? report->messages[0].text : "");
    if (report)
        tfa_report_free(report);
}

tfa_description *bundled_description(const char *file)
{
    char path[512];
    tfa_report report = {0};
    tfa_description *d = NULL;
    snprintf(path, sizeof path, TFA_SOURCE_DIR "/config/robots/%s", file);
    must(tfa_urdf_load(path, &d, &report), file, &report);
    return d;
}

char *bundled_text(const char *file)
{
    char path[512], *text = NULL;
    size_t size = 0;
    snprintf(path, sizeof path, TFA_SOURCE_DIR "/config/robots/%s", file);
    FILE *in = fopen(path, "r");
    assert_true(in != NULL && getdelim(&text, &size, 0, in) > 0);
    fclose(in);
    return text;
}

tfa_model *bundled_model(const char *file, const tfa_model_options *options)
{
    tfa_description *d = bundled_description(file);
    tfa_model *model = compiled(d, options);
    tfa_description_free(d);
    return model;
}

tfa_model *compiled(const tfa_description *description, const tfa_model_options *options)
{
    tfa_report report = {0};
    tfa_model *model = NULL;
    must(tfa_model_create(description, options, &report, &model), description->name, &report);
    return model;
}

tfa_workspace *workspace_for(const tfa_model *model, const tfa_workspace_options *options)
{
    tfa_workspace *w = NULL;
    must(tfa_workspace_create(model, options, &w), tfa_model_name(model), NULL);
    return w;
}
