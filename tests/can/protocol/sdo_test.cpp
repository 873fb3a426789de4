// Expedited SDO and emergencies, byte for byte. The set-up of a node with a server that answers, refuses,
// loses a value or is silent.
#include "can/protocol/sdo.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "can/protocol/node.h"
#include "can/protocol/protocol.h"
#include "tests/support/shows.h"

namespace hystcan::can::sdo_test {
namespace {

using std::chrono::milliseconds;
using Bytes = std::vector<std::uint8_t>;

Bytes bytes_of(const Frame& frame) { return {frame.payload().begin(), frame.payload().end()}; }
Frame frame_of(std::uint32_t id, const Bytes& bytes) {
  Frame frame{.id = id, .length = static_cast<std::uint8_t>(bytes.size())};
  std::ranges::copy(bytes, frame.data.begin());
  return frame;
}

constexpr SdoObject object{.index = 0x2001, .subindex = 0x05};

// 601#2B01200534120000: node 1, write 2 bytes 0x1234 to object 0x2001:05
TEST(SdoFrames, HaveTheBytesOfCiA301) {
  const auto write = [](std::uint32_t value, std::uint8_t bytes) {
    return sdo_request(
        1, {.service = SdoService::write, .object = object, .content = {.value = value, .bytes = bytes}});
  };
  EXPECT_EQ(write(0x1234, 2).id, 0x601u);
  EXPECT_EQ(bytes_of(write(0x12, 1)), (Bytes{0x2F, 0x01, 0x20, 0x05, 0x12, 0, 0, 0}));
  EXPECT_EQ(bytes_of(write(0x1234, 2)), (Bytes{0x2B, 0x01, 0x20, 0x05, 0x34, 0x12, 0, 0}));
  EXPECT_EQ(bytes_of(write(0x123456, 3)), (Bytes{0x27, 0x01, 0x20, 0x05, 0x56, 0x34, 0x12, 0}));
  EXPECT_EQ(bytes_of(write(0x12345678, 4)), (Bytes{0x23, 0x01, 0x20, 0x05, 0x78, 0x56, 0x34, 0x12}));
  EXPECT_EQ(bytes_of(sdo_request(1, {.service = SdoService::read, .object = object})),
            (Bytes{0x40, 0x01, 0x20, 0x05, 0, 0, 0, 0}));
  const Frame written = sdo_response(1, {.service = SdoService::written, .object = object});
  EXPECT_EQ(written.id, 0x581u);
  EXPECT_EQ(bytes_of(written), (Bytes{0x60, 0x01, 0x20, 0x05, 0, 0, 0, 0}));
  EXPECT_EQ(
      bytes_of(sdo_response(
          1, {.service = SdoService::value, .object = object, .content = {.value = 0x1234, .bytes = 2}})),
      (Bytes{0x4B, 0x01, 0x20, 0x05, 0x34, 0x12, 0, 0}));
  EXPECT_EQ(bytes_of(sdo_response(1, {.service = SdoService::abort,
                                      .object = object,
                                      .content = {.value = sdo_abort::no_such_object}})),
            (Bytes{0x80, 0x01, 0x20, 0x05, 0x00, 0x00, 0x02, 0x06}));
}

TEST(SdoFrames, AreParsedToTheMessageThatWasSent) {
  EXPECT_TRUE(rc::check([] {
    const auto bytes = *rc::gen::inRange<std::uint8_t>(1, 5);
    const std::uint32_t mask = 0xFFFF'FFFFU >> (32U - 8U * bytes);
    SdoMessage message{.service = SdoService::write,
                       .object = {.index = *rc::gen::arbitrary<std::uint16_t>(),
                                  .subindex = *rc::gen::arbitrary<std::uint8_t>()},
                       .content = {.value = *rc::gen::arbitrary<std::uint32_t>() & mask, .bytes = bytes}};
    RC_ASSERT(parse_sdo_request(sdo_request(7, message)) == message);
    message.service = SdoService::value;
    RC_ASSERT(parse_sdo_response(sdo_response(7, message)) == message);
  }));
}

TEST(SdoFrames, AreRejectedIfTheyAreNotExpedited) {
  for (const Bytes& bytes :
       {Bytes{0x00, 1, 0x20, 5, 4, 0, 0, 0}, Bytes{0x42, 1, 0x20, 5}, Bytes{0x60, 1, 0x20},
        Bytes{0x43, 1, 0x20, 5, 4, 0, 0}, Bytes{0x80, 1, 0x20, 5, 0, 0, 2}, Bytes{}})
    EXPECT_FALSE(parse_sdo_response(frame_of(0x581, bytes)));
  Frame extended = frame_of(0x581, {0x60, 1, 0x20, 5, 0, 0, 0, 0});
  extended.extended = true;
  EXPECT_FALSE(parse_sdo_response(extended));
}

TEST(SdoFrames, MayBeShortIfTheAnnouncedDataFits) {
  shows("S-107");
  EXPECT_EQ(parse_sdo_response(frame_of(0x581, {0x60, 1, 0x20, 5}))->service, SdoService::written);
  EXPECT_EQ(parse_sdo_response(frame_of(0x581, {0x4B, 1, 0x20, 5, 0x34, 0x12}))->content,
            (SdoValue{.value = 0x1234, .bytes = 2}));
  EXPECT_EQ(parse_sdo_response(frame_of(0x581, {0x42, 1, 0x20, 5, 0x34}))->content,
            (SdoValue{.value = 0x34, .bytes = 0}));
}

TEST(SdoAccess, IsTheBeginOfATransferOfAnyKind) {
  const auto access = [](unsigned command) {
    return sdo_access_of(frame_of(0x601, {static_cast<std::uint8_t>(command), 0x01, 0x20, 0x05, 0, 0, 0, 0}));
  };
  for (const unsigned write : {0x2FU, 0x23U, 0x22U, 0x21U, 0x20U, 0xC2U, 0xC6U}) {
    ASSERT_TRUE(access(write)) << write;
    EXPECT_EQ(access(write)->service, SdoService::write) << write;
    EXPECT_EQ(access(write)->object, object);
  }
  for (const unsigned read : {0x40U, 0xA0U, 0xA4U}) {
    ASSERT_TRUE(access(read)) << read;
    EXPECT_EQ(access(read)->service, SdoService::read) << read;
  }
  for (const unsigned neither : {0x00U, 0x10U, 0x60U, 0x70U, 0x80U, 0xA1U, 0xC1U})
    EXPECT_FALSE(access(neither));
}

TEST(SdoServer, KeepsWrittenObjects) {
  SdoServer server(3);
  const auto written = server.answer(frame_of(0x603, {0x2B, 0x01, 0x20, 0x05, 0x34, 0x12, 0, 0}));
  EXPECT_EQ(bytes_of(*written), (Bytes{0x60, 0x01, 0x20, 0x05, 0, 0, 0, 0}));
  const auto value = server.answer(frame_of(0x603, {0x40, 0x01, 0x20, 0x05, 0, 0, 0, 0}));
  EXPECT_EQ(value->id, 0x583u);
  EXPECT_EQ(bytes_of(*value), (Bytes{0x4B, 0x01, 0x20, 0x05, 0x34, 0x12, 0, 0}));
  EXPECT_EQ(server.object(object)->value, 0x1234u);
  EXPECT_FALSE(server.answer(frame_of(0x604, {0x40, 0x01, 0x20, 0x05, 0, 0, 0, 0})))
      << "the request is to another node";
}

TEST(SdoServer, RefusesWithTheAbortCodesOfCiA301) {
  SdoServer server(3);
  const auto code = [&](const Bytes& request) {
    const auto response = parse_sdo_response(*server.answer(frame_of(0x603, request)));
    return response->service == SdoService::abort ? response->content.value : 0;
  };
  EXPECT_EQ(code({0x40, 0x01, 0x20, 0x05, 0, 0, 0, 0}), sdo_abort::no_such_object);
  EXPECT_EQ(code({0x2F, 0x00, 0x10, 0x00, 1, 0, 0, 0}), sdo_abort::no_such_object)
      << "0x1000 is outside 0x2000 to 0x5FFF";
  EXPECT_EQ(code({0x2B, 0x01, 0x20, 0x05, 1, 0, 0, 0}), 0u);
  EXPECT_EQ(code({0x2F, 0x01, 0x20, 0x05, 1, 0, 0, 0}), sdo_abort::wrong_length);
  for (std::uint8_t i = 0; i < 63; ++i) EXPECT_EQ(code({0x2F, i, 0x30, 0x00, 1, 0, 0, 0}), 0u);
  EXPECT_EQ(code({0x2F, 0xFF, 0x30, 0x00, 1, 0, 0, 0}), sdo_abort::out_of_memory);
}

SdoSetup two_writes() {
  return {1,
          {{.object = {.index = 0x2000, .subindex = 1}, .content = {.value = 500, .bytes = 2}},
           {.object = {.index = 0x2001, .subindex = 0}, .content = {.value = 3, .bytes = 1}}}};
}

/// Polls every millisecond and passes each request to `answer`. Returns the number of requests.
template <class Answer>
int run(SdoSetup& setup, int for_ms, Answer answer) {
  int requests = 0;
  for (int ms = 0; ms < for_ms; ++ms) {
    const auto request = setup.poll(Time{milliseconds(ms)});
    if (!request) continue;
    ++requests;
    if (const auto response = answer(*request)) setup.handle(*response);
  }
  return requests;
}

TEST(SdoSetup, IsDoneAfterItHasWrittenAndReadBackEveryObject) {
  SdoServer server(1);
  SdoSetup setup = two_writes();
  EXPECT_EQ(run(setup, 10, [&](const Frame& frame) { return server.answer(frame); }), 4);
  EXPECT_TRUE(setup.is_done());
  EXPECT_EQ(server.object({.index = 0x2000, .subindex = 1})->value, 500u);
  EXPECT_EQ(server.object({.index = 0x2001, .subindex = 0})->value, 3u);
  setup.restart();
  EXPECT_FALSE(setup.is_done());
}

TEST(SdoSetup, TriesAgainAfterALostResponse) {
  SdoServer server(1);
  SdoSetup setup = two_writes();
  int count = 0;
  run(setup, 1000, [&](const Frame& frame) -> std::optional<Frame> {
    return ++count == 1 || count == 4 ? std::nullopt : server.answer(frame);
  });
  EXPECT_TRUE(setup.is_done());
  EXPECT_FALSE(setup.has_failed());
}

TEST(SdoSetup, FailsAfterThreeAttemptsIfTheNodeDoesNotAnswer) {
  shows("S-109");
  SdoSetup setup = two_writes();
  std::vector<Bytes> sent;
  run(setup, 1000, [&](const Frame& frame) {
    sent.push_back(bytes_of(frame));
    return std::optional<Frame>();
  });
  const Bytes write{0x2B, 0x00, 0x20, 0x01, 0xF4, 0x01, 0, 0};
  const Bytes timed_out{0x80, 0x00, 0x20, 0x01, 0x00, 0x00, 0x04, 0x05};
  EXPECT_EQ(sent, (std::vector<Bytes>{write, timed_out, write, timed_out, write, timed_out}));
  EXPECT_TRUE(setup.has_failed());
  EXPECT_EQ(describe(setup.failure()), "object 0x2000:01: the node does not answer");
}

TEST(SdoSetup, UsesTheConfiguredTimeoutAndNumberOfAttempts) {
  SdoSetup setup{1,
                 {{.object = object, .content = {.value = 9, .bytes = 1}}},
                 {.timeout = milliseconds(700), .attempts = 2}};
  const auto silence = [](const Frame&) { return std::optional<Frame>(); };
  EXPECT_EQ(run(setup, 1401, silence), 3) << "a request, its abort and the next request after 700 ms";
  EXPECT_FALSE(setup.has_failed());
  EXPECT_EQ(setup.poll(Time{milliseconds(1402)}).has_value(), true) << "the abort of the last attempt";
  EXPECT_TRUE(setup.has_failed());
}

TEST(SdoSetup, GivesTheReasonWhyTheNodeRefuses) {
  shows("S-109");
  SdoSetup setup{1, {{.object = object, .content = {.value = 9, .bytes = 1}}}};
  run(setup, 100, [&](const Frame&) {
    return std::optional(frame_of(0x581, {0x80, 0x01, 0x20, 0x05, 0x31, 0x00, 0x09, 0x06}));
  });
  EXPECT_TRUE(setup.has_failed());
  EXPECT_EQ(describe(setup.failure()),
            "object 0x2001:05: refused by the node with 0x06090031: value of the parameter too high");
}

/// Runs the set-up of one object of one byte, 9, with a node that answers each read with these bytes.
SdoSetup set_up_with(const Bytes& answer_to_read) {
  SdoSetup setup{1, {{.object = object, .content = {.value = 9, .bytes = 1}}}};
  run(setup, 100, [&](const Frame& request) {
    const bool write = request.data[0] == 0x2F;
    return std::optional(frame_of(0x581, write ? Bytes{0x60, 0x01, 0x20, 0x05, 0, 0, 0, 0} : answer_to_read));
  });
  return setup;
}

TEST(SdoSetup, FailsIfTheNodeDoesNotKeepAValue) {
  shows("S-109");
  const SdoSetup setup = set_up_with({0x4F, 0x01, 0x20, 0x05, 8, 0, 0, 0});
  EXPECT_TRUE(setup.has_failed());
  EXPECT_EQ(describe(setup.failure()), "object 0x2001:05: 0x9 was written, but 0x8 was read back");
}

TEST(SdoSetup, AcceptsAValueWithoutAStatedSize) {
  EXPECT_TRUE(set_up_with({0x42, 0x01, 0x20, 0x05, 9, 0, 0, 0}).is_done());
  EXPECT_TRUE(set_up_with({0x42, 0x01, 0x20, 0x05, 9, 7, 7, 7}).is_done()) << "only one byte is meant";
  EXPECT_TRUE(set_up_with({0x42, 0x01, 0x20, 0x05, 8, 0, 0, 0}).has_failed());
}

TEST(SdoSetup, FailsWithAReasonIfTheNodeAnswersInSegments) {
  shows("S-108");
  const SdoSetup setup = set_up_with({0x41, 0x01, 0x20, 0x05, 12, 0, 0, 0});
  EXPECT_TRUE(setup.has_failed());
  EXPECT_EQ(describe(setup.failure()),
            "object 0x2001:05: the node answers in segments, expected a value of at most 4 bytes");
}

TEST(SdoSetup, AcceptsShortResponses) { EXPECT_TRUE(set_up_with({0x4F, 0x01, 0x20, 0x05, 9}).is_done()); }

TEST(SdoSetup, IgnoresResponsesThatDoNotAnswerItsRequest) {
  SdoSetup setup = two_writes();
  setup.handle(frame_of(0x581, {0x60, 0x00, 0x20, 0x01, 0, 0, 0, 0}));  // before any request
  ASSERT_TRUE(setup.poll(Time{}));
  setup.handle(frame_of(0x581, {0x60, 0x07, 0x20, 0x01, 0, 0, 0, 0}));  // another object
  setup.handle(
      frame_of(0x581, {0x4B, 0x00, 0x20, 0x01, 0xF4, 1, 0, 0}));  // a value, but the request was a write
  EXPECT_FALSE(setup.poll(Time{milliseconds(1)}));
  setup.handle(frame_of(0x581, {0x60, 0x00, 0x20, 0x01, 0, 0, 0, 0}));
  EXPECT_EQ(bytes_of(*setup.poll(Time{milliseconds(2)})), (Bytes{0x40, 0x00, 0x20, 0x01, 0, 0, 0, 0}));
}

TEST(Sync, MayHaveNoData) {
  EXPECT_TRUE(is_sync({.id = 0x080, .length = 0}));
  EXPECT_TRUE(is_sync(sync_frame(240)));
  EXPECT_FALSE(is_sync({.id = 0x080, .length = 1, .data = {241}}));
  EXPECT_FALSE(is_sync({.id = 0x080, .length = 2}));
  EXPECT_FALSE(is_sync({.id = 0x77F, .length = 1, .data = {5}})) << "a heartbeat";
  EXPECT_FALSE(is_sync({.id = 0x080, .kind = FrameKind::remote, .length = 0}));
}

TEST(SdoAbort, HasATextForItsCode) {
  EXPECT_EQ(sdo_abort_text(0x0602'0000), "object does not exist in the object dictionary");
  EXPECT_EQ(sdo_abort_text(0x1234'5678), "unknown abort code");
}

// 081#3081010102030405: node 1, 0x8130, error register 0x01, manufacturer 01 02 03 04 05
TEST(Emergency, HasTheBytesOfCiA301) {
  const Frame frame =
      emergency_frame(1, {.code = 0x8130, .error_register = 0x01, .manufacturer = {1, 2, 3, 4, 5}});
  EXPECT_EQ(frame.id, 0x081u);
  EXPECT_EQ(bytes_of(frame), (Bytes{0x30, 0x81, 0x01, 1, 2, 3, 4, 5}));
  const auto parsed = parse_emergency(frame);
  EXPECT_EQ(parsed->code, 0x8130);
  EXPECT_EQ(parsed->manufacturer, (std::array<std::uint8_t, 5>{1, 2, 3, 4, 5}));
}

TEST(Emergency, HasTheTextOfItsCodeOrOfItsGroup) {
  EXPECT_EQ(emergency_text(0x8130), "life guard or heartbeat error");
  EXPECT_EQ(emergency_text(0x2310), "current, device output side");
  EXPECT_EQ(emergency_text(0x2F00), "current");
  EXPECT_EQ(emergency_text(0x1001), "generic error");
  EXPECT_EQ(emergency_text(0xFF42), "device-specific");
  EXPECT_EQ(emergency_text(0x0000), "error reset, or no error");
  EXPECT_EQ(emergency_text(0x0001), "reserved error code");
  EXPECT_EQ(emergency_text(0xA000), "reserved error code");
}

}  // namespace
}  // namespace hystcan::can::sdo_test
