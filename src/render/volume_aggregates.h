// Volumes in aggregates: which media rays of each kind know of, by the names that objects are in (Attribute "volume"
// "string[] aggregate") and those that an integrator asks for (its parameters "volumeAggregate", "volumeAggregateCamera",
// "volumeAggregateIndirect" and "volumeAggregateTransmission"). Media that no ray knows of are not made.
#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "base/diagnostics.h"
#include "plugin/registry.h"
#include "scene/scene.h"

namespace kinora::render {

// What an integrator asks for, by kind of ray. One without a parameter "volumeAggregate" asks for everything.
struct AggregateChoice {
  bool isMade = false;
  std::vector<std::string> camera, indirect, transmission;
  SourcePos pos;  // of the integrator
  bool operator==(const AggregateChoice& o) const {
    return isMade == o.isMade && camera == o.camera && indirect == o.indirect && transmission == o.transmission;
  }
};
// Of a plug-in as a node sets it; null: its defaults.
AggregateChoice aggregatesOf(const Descriptor& integrator, const scene::Node* node);

// The objects of a scene that are full of a medium, one after the other, and what is to be told of them in the end.
class Aggregates {
 public:
  // `interiors`: names that surfaces ask for as what is inside of them, which all rays know then.
  Aggregates(const AggregateChoice& choice, std::vector<std::string> interiors)
      : choice_(choice), interiors_(std::move(interiors)) {}
  // Of an object with these attributes (null: none), which other rules let be seen by `visibility`
  // (trace::VisibilityBits): what is left of that. 0: no ray knows of its medium.
  uint32_t visibilityOf(const scene::Attributes* attributes, uint32_t visibility, const std::string& object);
  // Names that no object is in, and objects that no ray knows of, once each.
  void tell(Diagnostics& diagnostics) const;

 private:
  const AggregateChoice& choice_;
  std::vector<std::string> interiors_;
  std::vector<std::string> met_, unseen_, firstUnseen_;  // names of aggregates; of objects' aggregates; objects
  uint32_t unseenCount_ = 0;
};

}  // namespace kinora::render
