/* foxglove_schemas: the channels, with JSON schemas of the members that our messages have. Those of Foxglove's own
 * messages are told by their names; viewers know the rest. */
#include "foxglove.h"

static const char SCENE_SCHEMA[] =
    "{\"type\":\"object\",\"title\":\"foxglove.SceneUpdate\",\"properties\":{\"deletions\":{\"type\":\"ar"
    "ray\",\"items\":{\"type\":\"object\",\"properties\":{\"timestamp\":{\"type\":\"object\",\"properties"
    "\":{\"sec\":{\"type\":\"integer\",\"minimum\":0},\"nsec\":{\"type\":\"integer\",\"minimum\":0,\"maxi"
    "mum\":999999999}}},\"type\":{\"type\":\"integer\"},\"id\":{\"type\":\"string\"}}}},\"entities\":{\"t"
    "ype\":\"array\",\"items\":{\"type\":\"object\",\"properties\":{\"timestamp\":{\"type\":\"object\",\""
    "properties\":{\"sec\":{\"type\":\"integer\",\"minimum\":0},\"nsec\":{\"type\":\"integer\",\"minimum"
    "\":0,\"maximum\":999999999}}},\"frame_id\":{\"type\":\"string\"},\"id\":{\"type\":\"string\"},\"life"
    "time\":{\"type\":\"object\",\"properties\":{\"sec\":{\"type\":\"integer\",\"minimum\":0},\"nsec\":{"
    "\"type\":\"integer\",\"minimum\":0,\"maximum\":999999999}}},\"frame_locked\":{\"type\":\"boolean\"},"
    "\"metadata\":{\"type\":\"array\",\"items\":{\"type\":\"object\",\"properties\":{\"key\":{\"type\":\""
    "string\"},\"value\":{\"type\":\"string\"}}}},\"arrows\":{\"type\":\"array\",\"items\":{\"type\":\"ob"
    "ject\",\"properties\":{\"pose\":{\"type\":\"object\",\"properties\":{\"position\":{\"type\":\"object"
    "\",\"properties\":{\"x\":{\"type\":\"number\"},\"y\":{\"type\":\"number\"},\"z\":{\"type\":\"number"
    "\"}}},\"orientation\":{\"type\":\"object\",\"properties\":{\"x\":{\"type\":\"number\"},\"y\":{\"type"
    "\":\"number\"},\"z\":{\"type\":\"number\"},\"w\":{\"type\":\"number\"}}}}},\"shaft_length\":{\"type"
    "\":\"number\"},\"shaft_diameter\":{\"type\":\"number\"},\"head_length\":{\"type\":\"number\"},\"head"
    "_diameter\":{\"type\":\"number\"},\"color\":{\"type\":\"object\",\"properties\":{\"r\":{\"type\":\"n"
    "umber\"},\"g\":{\"type\":\"number\"},\"b\":{\"type\":\"number\"},\"a\":{\"type\":\"number\"}}}}}},\""
    "cubes\":{\"type\":\"array\",\"items\":{\"type\":\"object\",\"properties\":{\"pose\":{\"type\":\"obje"
    "ct\",\"properties\":{\"position\":{\"type\":\"object\",\"properties\":{\"x\":{\"type\":\"number\"},"
    "\"y\":{\"type\":\"number\"},\"z\":{\"type\":\"number\"}}},\"orientation\":{\"type\":\"object\",\"pro"
    "perties\":{\"x\":{\"type\":\"number\"},\"y\":{\"type\":\"number\"},\"z\":{\"type\":\"number\"},\"w\""
    ":{\"type\":\"number\"}}}}},\"size\":{\"type\":\"object\",\"properties\":{\"x\":{\"type\":\"number\"}"
    ",\"y\":{\"type\":\"number\"},\"z\":{\"type\":\"number\"}}},\"color\":{\"type\":\"object\",\"properti"
    "es\":{\"r\":{\"type\":\"number\"},\"g\":{\"type\":\"number\"},\"b\":{\"type\":\"number\"},\"a\":{\"t"
    "ype\":\"number\"}}}}}},\"spheres\":{\"type\":\"array\",\"items\":{\"type\":\"object\",\"properties\""
    ":{\"pose\":{\"type\":\"object\",\"properties\":{\"position\":{\"type\":\"object\",\"properties\":{\""
    "x\":{\"type\":\"number\"},\"y\":{\"type\":\"number\"},\"z\":{\"type\":\"number\"}}},\"orientation\":"
    "{\"type\":\"object\",\"properties\":{\"x\":{\"type\":\"number\"},\"y\":{\"type\":\"number\"},\"z\":{"
    "\"type\":\"number\"},\"w\":{\"type\":\"number\"}}}}},\"size\":{\"type\":\"object\",\"properties\":{"
    "\"x\":{\"type\":\"number\"},\"y\":{\"type\":\"number\"},\"z\":{\"type\":\"number\"}}},\"color\":{\"t"
    "ype\":\"object\",\"properties\":{\"r\":{\"type\":\"number\"},\"g\":{\"type\":\"number\"},\"b\":{\"ty"
    "pe\":\"number\"},\"a\":{\"type\":\"number\"}}}}}},\"cylinders\":{\"type\":\"array\",\"items\":{\"typ"
    "e\":\"object\",\"properties\":{\"pose\":{\"type\":\"object\",\"properties\":{\"position\":{\"type\":"
    "\"object\",\"properties\":{\"x\":{\"type\":\"number\"},\"y\":{\"type\":\"number\"},\"z\":{\"type\":"
    "\"number\"}}},\"orientation\":{\"type\":\"object\",\"properties\":{\"x\":{\"type\":\"number\"},\"y\""
    ":{\"type\":\"number\"},\"z\":{\"type\":\"number\"},\"w\":{\"type\":\"number\"}}}}},\"size\":{\"type"
    "\":\"object\",\"properties\":{\"x\":{\"type\":\"number\"},\"y\":{\"type\":\"number\"},\"z\":{\"type"
    "\":\"number\"}}},\"bottom_scale\":{\"type\":\"number\"},\"top_scale\":{\"type\":\"number\"},\"color"
    "\":{\"type\":\"object\",\"properties\":{\"r\":{\"type\":\"number\"},\"g\":{\"type\":\"number\"},\"b"
    "\":{\"type\":\"number\"},\"a\":{\"type\":\"number\"}}}}}},\"lines\":{\"type\":\"array\",\"items\":{"
    "\"type\":\"object\",\"properties\":{\"type\":{\"type\":\"integer\"},\"pose\":{\"type\":\"object\",\""
    "properties\":{\"position\":{\"type\":\"object\",\"properties\":{\"x\":{\"type\":\"number\"},\"y\":{"
    "\"type\":\"number\"},\"z\":{\"type\":\"number\"}}},\"orientation\":{\"type\":\"object\",\"properties"
    "\":{\"x\":{\"type\":\"number\"},\"y\":{\"type\":\"number\"},\"z\":{\"type\":\"number\"},\"w\":{\"typ"
    "e\":\"number\"}}}}},\"thickness\":{\"type\":\"number\"},\"scale_invariant\":{\"type\":\"boolean\"},"
    "\"points\":{\"type\":\"array\",\"items\":{\"type\":\"object\",\"properties\":{\"x\":{\"type\":\"numb"
    "er\"},\"y\":{\"type\":\"number\"},\"z\":{\"type\":\"number\"}}}},\"color\":{\"type\":\"object\",\"pr"
    "operties\":{\"r\":{\"type\":\"number\"},\"g\":{\"type\":\"number\"},\"b\":{\"type\":\"number\"},\"a"
    "\":{\"type\":\"number\"}}},\"colors\":{\"type\":\"array\",\"items\":{\"type\":\"object\",\"propertie"
    "s\":{\"r\":{\"type\":\"number\"},\"g\":{\"type\":\"number\"},\"b\":{\"type\":\"number\"},\"a\":{\"ty"
    "pe\":\"number\"}}}},\"indices\":{\"type\":\"array\",\"items\":{\"type\":\"integer\"}}}}},\"triangles"
    "\":{\"type\":\"array\",\"items\":{\"type\":\"object\",\"properties\":{\"pose\":{\"type\":\"object\","
    "\"properties\":{\"position\":{\"type\":\"object\",\"properties\":{\"x\":{\"type\":\"number\"},\"y\":"
    "{\"type\":\"number\"},\"z\":{\"type\":\"number\"}}},\"orientation\":{\"type\":\"object\",\"propertie"
    "s\":{\"x\":{\"type\":\"number\"},\"y\":{\"type\":\"number\"},\"z\":{\"type\":\"number\"},\"w\":{\"ty"
    "pe\":\"number\"}}}}},\"points\":{\"type\":\"array\",\"items\":{\"type\":\"object\",\"properties\":{"
    "\"x\":{\"type\":\"number\"},\"y\":{\"type\":\"number\"},\"z\":{\"type\":\"number\"}}}},\"color\":{\""
    "type\":\"object\",\"properties\":{\"r\":{\"type\":\"number\"},\"g\":{\"type\":\"number\"},\"b\":{\"t"
    "ype\":\"number\"},\"a\":{\"type\":\"number\"}}},\"colors\":{\"type\":\"array\",\"items\":{\"type\":"
    "\"object\",\"properties\":{\"r\":{\"type\":\"number\"},\"g\":{\"type\":\"number\"},\"b\":{\"type\":"
    "\"number\"},\"a\":{\"type\":\"number\"}}}},\"indices\":{\"type\":\"array\",\"items\":{\"type\":\"int"
    "eger\"}}}}},\"texts\":{\"type\":\"array\",\"items\":{\"type\":\"object\",\"properties\":{\"pose\":{"
    "\"type\":\"object\",\"properties\":{\"position\":{\"type\":\"object\",\"properties\":{\"x\":{\"type"
    "\":\"number\"},\"y\":{\"type\":\"number\"},\"z\":{\"type\":\"number\"}}},\"orientation\":{\"type\":"
    "\"object\",\"properties\":{\"x\":{\"type\":\"number\"},\"y\":{\"type\":\"number\"},\"z\":{\"type\":"
    "\"number\"},\"w\":{\"type\":\"number\"}}}}},\"billboard\":{\"type\":\"boolean\"},\"font_size\":{\"ty"
    "pe\":\"number\"},\"scale_invariant\":{\"type\":\"boolean\"},\"color\":{\"type\":\"object\",\"propert"
    "ies\":{\"r\":{\"type\":\"number\"},\"g\":{\"type\":\"number\"},\"b\":{\"type\":\"number\"},\"a\":{\""
    "type\":\"number\"}}},\"text\":{\"type\":\"string\"}}}},\"models\":{\"type\":\"array\",\"items\":{\"t"
    "ype\":\"object\",\"properties\":{\"pose\":{\"type\":\"object\",\"properties\":{\"position\":{\"type"
    "\":\"object\",\"properties\":{\"x\":{\"type\":\"number\"},\"y\":{\"type\":\"number\"},\"z\":{\"type"
    "\":\"number\"}}},\"orientation\":{\"type\":\"object\",\"properties\":{\"x\":{\"type\":\"number\"},\""
    "y\":{\"type\":\"number\"},\"z\":{\"type\":\"number\"},\"w\":{\"type\":\"number\"}}}}},\"scale\":{\"t"
    "ype\":\"object\",\"properties\":{\"x\":{\"type\":\"number\"},\"y\":{\"type\":\"number\"},\"z\":{\"ty"
    "pe\":\"number\"}}},\"color\":{\"type\":\"object\",\"properties\":{\"r\":{\"type\":\"number\"},\"g\":"
    "{\"type\":\"number\"},\"b\":{\"type\":\"number\"},\"a\":{\"type\":\"number\"}}},\"override_color\":{"
    "\"type\":\"boolean\"},\"url\":{\"type\":\"string\"},\"media_type\":{\"type\":\"string\"},\"data\":{"
    "\"type\":\"string\",\"contentEncoding\":\"base64\"}}}}}}}}}";

static const char TRANSFORMS_SCHEMA[] =
    "{\"type\":\"object\",\"title\":\"foxglove.FrameTransforms\",\"properties\":{\"transforms\":{\"type\""
    ":\"array\",\"items\":{\"type\":\"object\",\"properties\":{\"timestamp\":{\"type\":\"object\",\"prope"
    "rties\":{\"sec\":{\"type\":\"integer\",\"minimum\":0},\"nsec\":{\"type\":\"integer\",\"minimum\":0,"
    "\"maximum\":999999999}}},\"parent_frame_id\":{\"type\":\"string\"},\"child_frame_id\":{\"type\":\"st"
    "ring\"},\"translation\":{\"type\":\"object\",\"properties\":{\"x\":{\"type\":\"number\"},\"y\":{\"ty"
    "pe\":\"number\"},\"z\":{\"type\":\"number\"}}},\"rotation\":{\"type\":\"object\",\"properties\":{\"x"
    "\":{\"type\":\"number\"},\"y\":{\"type\":\"number\"},\"z\":{\"type\":\"number\"},\"w\":{\"type\":\"n"
    "umber\"}}}}}}}}";

static const char EVENT_SCHEMA[] =
    "{\"type\":\"object\",\"title\":\"collided.Event\",\"properties\":{\"timestamp\":{\"type\":\"object\""
    ",\"properties\":{\"sec\":{\"type\":\"integer\",\"minimum\":0},\"nsec\":{\"type\":\"integer\",\"minim"
    "um\":0,\"maximum\":999999999}}},\"kind\":{\"type\":\"string\"},\"contact\":{\"type\":\"string\"},\"t"
    "ick\":{\"type\":\"integer\"},\"a\":{\"type\":\"string\"},\"b\":{\"type\":\"string\"},\"cause\":{\"ty"
    "pe\":\"string\"},\"shape_a\":{\"type\":\"integer\"},\"shape_b\":{\"type\":\"integer\"},\"lo\":{\"typ"
    "e\":\"number\"},\"hi\":{\"type\":\"number\"},\"closing\":{\"type\":\"number\"},\"age_a\":{\"type\":"
    "\"number\"},\"age_b\":{\"type\":\"number\"},\"lo_s\":{\"type\":\"number\"},\"hi_s\":{\"type\":\"numb"
    "er\"},\"achieved\":{\"type\":\"integer\"},\"snapshot\":{\"type\":\"boolean\"}},\"required\":[\"times"
    "tamp\",\"kind\",\"contact\",\"tick\"],\"additionalProperties\":false}";

static const char DISTANCES_SCHEMA[] =
    "{\"type\":\"object\",\"title\":\"collided.Distances\",\"properties\":{\"timestamp\":{\"type\":\"obje"
    "ct\",\"properties\":{\"sec\":{\"type\":\"integer\",\"minimum\":0},\"nsec\":{\"type\":\"integer\",\"m"
    "inimum\":0,\"maximum\":999999999}}},\"tick\":{\"type\":\"integer\"},\"bodies\":{\"type\":\"integer\""
    "},\"stale\":{\"type\":\"integer\"},\"touching\":{\"type\":\"integer\"},\"near\":{\"type\":\"integer"
    "\"},\"unknown\":{\"type\":\"integer\"},\"predicted\":{\"type\":\"integer\"},\"nearest_lo\":{\"type\""
    ":\"number\"},\"nearest_hi\":{\"type\":\"number\"},\"nearest_closing\":{\"type\":\"number\"},\"neares"
    "t_a\":{\"type\":\"string\"},\"nearest_b\":{\"type\":\"string\"},\"soonest_s\":{\"type\":\"number\"},"
    "\"soonest_a\":{\"type\":\"string\"},\"soonest_b\":{\"type\":\"string\"}},\"required\":[\"timestamp\""
    ",\"tick\",\"bodies\",\"stale\",\"touching\",\"near\",\"unknown\",\"predicted\"],\"additionalProperti"
    "es\":false}";

static const char LOG_SCHEMA[] =
    "{\"type\":\"object\",\"title\":\"foxglove.Log\",\"properties\":{\"timestamp\":{\"type\":\"object\","
    "\"properties\":{\"sec\":{\"type\":\"integer\",\"minimum\":0},\"nsec\":{\"type\":\"integer\",\"minimu"
    "m\":0,\"maximum\":999999999}}},\"level\":{\"type\":\"integer\"},\"message\":{\"type\":\"string\"},\""
    "name\":{\"type\":\"string\"},\"file\":{\"type\":\"string\"},\"line\":{\"type\":\"integer\"}}}";

const foxglove_channel foxglove_channels[FOXGLOVE_TOPICS] = {
    {"/collided/scene", "foxglove.SceneUpdate", SCENE_SCHEMA},
    {"/collided/transforms", "foxglove.FrameTransforms", TRANSFORMS_SCHEMA},
    {"/collided/contacts", "foxglove.SceneUpdate", SCENE_SCHEMA},
    {"/collided/events", "collided.Event", EVENT_SCHEMA},
    {"/collided/distances", "collided.Distances", DISTANCES_SCHEMA},
    {"/collided/log", "foxglove.Log", LOG_SCHEMA},
};
