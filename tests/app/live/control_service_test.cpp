#include "app/live/control_service.h"

#include <gtest/gtest.h>

#include <boost/asio/post.hpp>
#include <new>

namespace hystcan::app::control_service_test {
namespace {

TEST(ControlServiceThread, ContinuesAfterAHandlerThrows) {
  boost::asio::io_context context;
  bool reached = false;
  boost::asio::post(context, [] { throw std::bad_alloc(); });
  boost::asio::post(context, [] { throw 7; });
  boost::asio::post(context, [&] {
    reached = true;
    context.stop();
  });
  run_despite_exceptions(context);
  EXPECT_TRUE(reached);
}

}  // namespace
}  // namespace hystcan::app::control_service_test
