#pragma once
// What both programs of the peer need of Fast DDS: a participant on the loopback interface, readers and writers.
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <chrono>
#include <cstdint>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <string>

namespace peer {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

struct Qos {
  bool reliable = true, transient_local = false;
  int depth = 10;
};

class Node {
 public:
  explicit Node(std::uint32_t domain) {
    dds::DomainParticipantQos qos;
    auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    udp->interfaceWhiteList.push_back("127.0.0.1");
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(udp);
    for (std::uint32_t i = 0; i < 8; ++i) {  // of the first participants of this domain
      rtps::Locator_t locator;
      rtps::IPLocator::setIPv4(locator, "127.0.0.1");
      locator.port = 7410 + 250 * domain + 2 * i;
      qos.wire_protocol().builtin.initialPeersList.push_back(locator);
    }
    participant_ = dds::DomainParticipantFactory::get_instance()->create_participant(domain, qos);
    publisher_ = participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
    subscriber_ = participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
  }

  template <class PubSub>
  dds::DataWriter* writer(const std::string& topic, const Qos& how = {}) {
    dds::DataWriterQos qos;
    qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    qos.publish_mode().kind = dds::ASYNCHRONOUS_PUBLISH_MODE;  // pictures are larger than a datagram
    qos.data_sharing().off();
    fill(qos, how);
    return publisher_->create_datawriter(topic_of<PubSub>(topic), qos);
  }
  template <class PubSub>
  dds::DataReader* reader(const std::string& topic, const Qos& how, dds::DataReaderListener* listener) {
    dds::DataReaderQos qos;
    qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    qos.data_sharing().off();
    fill(qos, how);
    return subscriber_->create_datareader(topic_of<PubSub>(topic), qos, listener);
  }

 private:
  template <class PubSub>
  dds::Topic* topic_of(const std::string& name) {
    dds::TypeSupport type(new PubSub());
    type.register_type(participant_);
    if (auto* known = dynamic_cast<dds::Topic*>(participant_->lookup_topicdescription(name))) return known;
    return participant_->create_topic(name, type.get_type_name(), dds::TOPIC_QOS_DEFAULT);
  }
  template <class Q>
  static void fill(Q& qos, const Qos& how) {
    qos.reliability().kind = how.reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
    qos.durability().kind = how.transient_local ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
    qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = how.depth;
  }

  dds::DomainParticipant* participant_;
  dds::Publisher* publisher_;
  dds::Subscriber* subscriber_;
};

}  // namespace peer
