// A card in memory; a test can make its conversions fail.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "node/analogue/config.h"

namespace hystcan::node {

struct FakeCard final : Card {
  VoltageRange range{-10.0, 10.0, 0.001};
  std::map<unsigned, double> outputs_V;
  std::map<unsigned, double> inputs_V;
  std::map<unsigned, bool> lines;
  std::vector<std::string> order;  ///< order of the conversions and of the writes to lines
  bool fails = false;

  std::unique_ptr<VoltageOutput> output(const CardChannel& place) override {
    check(place);
    return std::make_unique<Output>(*this, place.channel);
  }
  std::unique_ptr<VoltageInput> input(const CardChannel& place) override {
    check(place);
    return std::make_unique<Input>(*this, place.channel);
  }
  std::unique_ptr<LineOutput> line_output(const CardChannel& place) override {
    return std::make_unique<OutLine>(*this, place.channel);
  }
  VoltageRange check_output(const CardChannel& place) override {
    check(place);
    return range;
  }
  void check_line_output(const CardChannel& place) override { check(place); }
  void check_line_input(const CardChannel& place) override { check(place); }
  std::unique_ptr<LineInput> line_input(const CardChannel& place) override {
    return std::make_unique<InLine>(*this, place.channel);
  }

 private:
  void check(const CardChannel& place) const {
    if (place.channel >= 8) throw Error("the card has 8 channels");
  }

  struct Output final : VoltageOutput {
    Output(FakeCard& owner, unsigned number) : card(owner), channel(number) {}
    const VoltageRange& range() const override { return card.range; }
    bool write(double volts) override {
      if (card.fails) return false;
      card.outputs_V[channel] = volts;
      card.order.push_back("output");
      return true;
    }
    FakeCard& card;
    unsigned channel;
  };
  struct Input final : VoltageInput {
    Input(FakeCard& owner, unsigned number) : card(owner), channel(number) {}
    const VoltageRange& range() const override { return card.range; }
    std::optional<double> read() override {
      if (card.fails) return std::nullopt;
      card.order.push_back("input");
      return card.inputs_V[channel];
    }
    FakeCard& card;
    unsigned channel;
  };
  struct OutLine final : LineOutput {
    OutLine(FakeCard& owner, unsigned number) : card(owner), line(number) {}
    bool write(bool on) override {
      if (card.fails) return false;
      card.lines[line] = on;
      card.order.push_back("line");
      return true;
    }
    FakeCard& card;
    unsigned line;
  };
  struct InLine final : LineInput {
    InLine(FakeCard& owner, unsigned number) : card(owner), line(number) {}
    std::optional<bool> read() override {
      if (card.fails) return std::nullopt;
      return card.lines[line];
    }
    FakeCard& card;
    unsigned line;
  };
};

/// Output and position on channel 0, monitor on input 1, lines 0, 1 and 2.
inline AnalogueConfig connected_to_fake() {
  AnalogueConfig config;
  config.device = "comedi:/fake";
  config.volts_per_drive = 0.1;
  config.position_um_per_V = 3.0;
  config.output_input.emplace().channel = 1;
  config.enable_line.emplace().active = ActiveLevel::low;
  config.interlock_line.emplace().place.channel = 1;
  config.charge_pump_line.emplace().place.channel = 2;
  return config;
}

}  // namespace hystcan::node
