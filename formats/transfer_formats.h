/* Transfer functions in JSON: what transfer_json.c (reading the file, this project's form) asks of other
 * forms. */
#ifndef FORMATS_TRANSFER_FORMATS_H
#define FORMATS_TRANSFER_FORMATS_H

#include <cjson/cJSON.h>

#include <formats/formats.h>

/* A ParaView colour map: one object of its list. path is for messages. */
int transfer_paraview_parse(struct brick_transfer_spec *spec, const char *path, const cJSON *map,
                            struct brick_error *err);

#endif
