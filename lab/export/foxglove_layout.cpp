#include "lab/export/foxglove_layout.h"

#include "cx/base/json.h"

namespace cxlab::lab {

namespace {

/// The topics that begin with a prefix.
std::vector<std::string> below(const std::vector<std::string>& topics, const std::string& prefix) {
  std::vector<std::string> out;
  for (const std::string& topic : topics)
    if (topic.starts_with(prefix)) out.push_back(topic);
  return out;
}

Json beside(Json first, Json second, double share) {
  return {{"first", std::move(first)}, {"second", std::move(second)}, {"direction", "row"}, {"splitPercentage", share}};
}

Json above(Json first, Json second, double share) {
  Json out = beside(std::move(first), std::move(second), share);
  out["direction"] = "column";
  return out;
}

}  // namespace

std::string foxglove_layout(const std::vector<std::string>& topics) {
  const std::string skills = "/cxlab/skills/", points = "/cxlab/points/";
  Json shown = Json::object(), states = Json::array(), lines = Json::array();
  for (const std::string& topic : below(topics, "/cxlab/scene/")) shown[topic] = {{"visible", true}};
  for (const std::string& topic : below(topics, skills))
    states.push_back(
        {{"value", topic + ".state"}, {"label", topic.substr(skills.size())}, {"timestampMethod", "receiveTime"}});
  for (const std::string& topic : below(topics, points))
    lines.push_back({{"value", topic + ".total"},
                     {"label", topic.substr(points.size())},
                     {"enabled", true},
                     {"timestampMethod", "receiveTime"}});
  const Json camera{{"distance", 16},
                    {"perspective", true},
                    {"phi", 40},
                    {"thetaOffset", 0},
                    {"targetOffset", {0, 3, 0}},
                    {"target", {0, 0, 0}},
                    {"targetOrientation", {0, 0, 0, 1}},
                    {"fovy", 45},
                    {"near", 0.1},
                    {"far", 500}};
  const Json grid{{"layerId", "foxglove.Grid"},
                  {"instanceId", "grid"},
                  {"frameId", "map"},
                  {"visible", true},
                  {"size", 14},
                  {"divisions", 14},
                  {"lineWidth", 1},
                  {"color", "#5a5a5aff"}};
  const Json panels{{"3D!world",
                     {{"cameraState", camera},
                      {"followMode", "follow-none"},
                      {"followTf", "map"},
                      {"scene", {{"transforms", {{"showLabel", false}, {"axisScale", 0}}}}},
                      {"topics", std::move(shown)},
                      {"layers", {{"grid", grid}}}}},
                    {"StateTransitions!skills", {{"paths", std::move(states)}, {"isSynced", true}}},
                    {"Plot!points",
                     {{"paths", std::move(lines)},
                      {"xAxisVal", "timestamp"},
                      {"showLegend", true},
                      {"isSynced", true},
                      {"foxglovePanelTitle", "Points"}}},
                    {"RosOut!log", {{"topicToRender", "/rosout"}, {"minLogLevel", 1}, {"searchTerms", Json::array()}}},
                    {"RawMessages!events",
                     {{"topicPath", "/cxlab/events"}, {"diffEnabled", false}, {"showFullMessageForDiff", false}}}};
  const Json layout{{"configById", panels},
                    {"globalVariables", Json::object()},
                    {"userNodes", Json::object()},
                    {"playbackConfig", {{"speed", 1}}},
                    {"layout", above(beside("3D!world", above("RawMessages!events", "RosOut!log", 50), 65),
                                     beside("StateTransitions!skills", "Plot!points", 65), 65)}};
  return json_text(layout, 2) + '\n';
}

}  // namespace cxlab::lab
