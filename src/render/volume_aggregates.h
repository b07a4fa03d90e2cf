// Volumes in aggregates: which media rays of each kind know of, by the names that objects are in (Attribute "volume"
// "string[] aggregate") and those that an integrator asks for (its parameters "volumeAggregate", "volumeAggregateCamera",
// "volumeAggregateIndirect" and "volumeAggregateTransmission"), everywhere, or that a surface asks for (its material's
// parameter "volumeAggregateName"), inside of it. Media that no ray knows of are not made.
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

// Names of the aggregates that surfaces of these attributes (null: none) have inside. None: their material names none,
// or encloses nothing.
std::vector<std::string> aggregatesInside(const scene::Attributes* attributes, Registry& registry,
                                          Diagnostics& diagnostics);

// Which rays know of a medium, as trace::VisibilityBits.
struct AggregateSight {
  uint32_t everywhere = 0;
  uint32_t inside = 0;             // only where they are inside a surface that asks for it
  std::vector<uint32_t> insideOf;  // by which names such surfaces ask for it: numbers of `interiors`
};

// The objects of a scene that are full of a medium, one after the other, and what is to be told of them in the end.
class Aggregates {
 public:
  // `interiors`: names that surfaces ask for as what is inside of them, once each.
  Aggregates(const AggregateChoice& choice, std::vector<std::string> interiors)
      : choice_(choice), interiors_(std::move(interiors)) {}
  // Of an object with these attributes (null: none), which other rules let be seen by `visibility`
  // (trace::VisibilityBits): what is left of that.
  AggregateSight sightOf(const scene::Attributes* attributes, uint32_t visibility, const std::string& object);
  // Names that no object is in, and objects that no ray knows of, once each.
  void tell(Diagnostics& diagnostics) const;

 private:
  const AggregateChoice& choice_;
  std::vector<std::string> interiors_;
  std::vector<std::string> met_, unseen_, firstUnseen_;  // names of aggregates; of objects' aggregates; objects
  uint32_t unseenCount_ = 0;
};

}  // namespace kinora::render
