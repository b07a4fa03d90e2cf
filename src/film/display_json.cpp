// The outputs of a plan as JSON inside shards. What is read back comes from a file and is checked.
#include <nlohmann/json.hpp>

#include "film/display_output.h"

namespace kinora::film {
namespace {
using nlohmann::json;
}

std::string outputsToJson(const DisplayPlan& plan, const FrameMetadata& frame) {
  json outputs = json::array();
  for (const Output& o : plan.outputs) {
    json channels = json::array(), params = json::array();
    for (const OutputChannel& c : o.channels)
      channels.push_back({{"channel", plan.layout[c.channel].name},
                          {"names", c.names},
                          {"isColor", c.isColor},
                          {"exposure", {c.values.gain, c.values.gamma}},
                          {"quantize", {c.values.zero, c.values.one, c.values.least, c.values.most}},
                          {"dither", c.values.dither}});
    for (const scene::Parameter& p : o.params)
      params.push_back({{"name", p.name},
                        {"type", int(p.type)},
                        {"isArray", p.isArray},
                        {"length", p.arrayLength},
                        {"floats", p.floats},
                        {"ints", p.ints},
                        {"strings", p.strings}});
    outputs.push_back({{"file", o.file}, {"driver", o.driver}, {"channels", channels}, {"params", params}});
  }
  return json{{"outputs", outputs},
              {"pixelAspect", plan.pixelAspect},
              {"worldToCamera", frame.worldToCamera},
              {"worldToNDC", frame.worldToNdc}}
      .dump(-1, ' ', false, json::error_handler_t::replace);
}

image::Status outputsFromJson(const std::string& text, const ChannelLayout& layout, DisplayPlan& out,
                              FrameMetadata& frame) {
  out = {};
  out.layout = layout;
  try {
    const json j = json::parse(text);
    out.pixelAspect = j.at("pixelAspect").get<float>();
    frame.worldToCamera = j.at("worldToCamera").get<image::Matrix44>();
    frame.worldToNdc = j.at("worldToNDC").get<image::Matrix44>();
    for (const json& o : j.at("outputs")) {
      Output output;
      output.file = o.at("file").get<std::string>();
      output.driver = o.at("driver").get<std::string>();
      for (const json& c : o.at("channels")) {
        OutputChannel channel;
        channel.channel = layout.find(c.at("channel").get<std::string>());
        channel.names = c.at("names").get<std::vector<std::string>>();
        channel.isColor = c.at("isColor").get<bool>();
        const auto exposure = c.at("exposure").get<std::array<float, 2>>();
        const auto quantize = c.at("quantize").get<std::array<float, 4>>();
        channel.values = {exposure[0],
                          exposure[1],
                          quantize[0],
                          quantize[1],
                          quantize[2],
                          quantize[3],
                          c.at("dither").get<float>()};
        if (channel.channel < 0 || int(channel.names.size()) != layout[channel.channel].width)
          throw std::runtime_error("a picture names a channel that the shard lacks");
        output.channels.push_back(std::move(channel));
      }
      for (const json& p : o.at("params")) {
        scene::Parameter parameter;
        parameter.name = p.at("name").get<std::string>();
        const int type = p.at("type").get<int>();
        if (type < 0 || type > int(scene::ValueType::Struct))
          throw std::runtime_error("a parameter has no known type");
        parameter.type = scene::ValueType(type);
        parameter.isArray = p.at("isArray").get<bool>();
        parameter.arrayLength = p.at("length").get<int>();
        parameter.floats = p.at("floats").get<std::vector<float>>();
        parameter.ints = p.at("ints").get<std::vector<int>>();
        parameter.strings = p.at("strings").get<std::vector<std::string>>();
        output.params.set(std::move(parameter));
      }
      if (output.channels.empty()) throw std::runtime_error("a picture has no channels");
      out.outputs.push_back(std::move(output));
    }
  } catch (const std::exception& e) {
    out = {};
    return image::Status::fail("FILM-SHARD-OUTPUTS",
                               std::string("the shard's description of its pictures: ") + e.what());
  }
  return {};
}

}  // namespace kinora::film
