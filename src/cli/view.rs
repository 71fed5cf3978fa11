//! `--view`: shows the picture in progress in tev or another viewer with the same protocol.

use super::Console;
use crate::film::{Film, Plane};
use crate::session::{Provenance, picture_name};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};
use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

/// Timeout for the viewer to answer or to read; the render waits for it.
const PATIENCE: Duration = Duration::from_millis(500);
/// Minimum interval between updates.
const INTERVAL: Duration = Duration::from_secs(1);

const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// Parses `host:port`.
pub(super) fn address(text: &str) -> Result<SocketAddr, String> {
    let wrong = |cause: &dyn std::fmt::Display| {
        format!("'{text}' is not the address of a viewer, such as localhost:14158: {cause}")
    };
    let mut found = text.to_socket_addrs().map_err(|cause| wrong(&cause))?;
    found.next().ok_or_else(|| wrong(&"no such host"))
}

/// A connected viewer.
pub(super) struct View {
    client: TevClient,
    name: String,
    next: Instant,
}

impl View {
    /// Connects to the viewer at `address` and opens the picture there; `None` if nothing listens.
    pub(super) fn open(address: SocketAddr, provenance: &Provenance, film: &Film, console: Console) -> Option<View> {
        let connected = TcpStream::connect_timeout(&address, PATIENCE).and_then(|stream| {
            stream.set_write_timeout(Some(PATIENCE))?;
            Ok(stream)
        });
        let name = picture_name(&provenance.scene.path).to_string_lossy().into_owned();
        let opened = connected.and_then(|stream| {
            let crop = film.layout().crop;
            let mut client = TevClient::wrap(stream);
            client.send(PacketCreateImage {
                image_name: &name,
                grab_focus: true,
                width: crop.x1 - crop.x0,
                height: crop.y1 - crop.y0,
                channel_names: &CHANNELS,
            })?;
            Ok(client)
        });
        match opened {
            Ok(client) => Some(View { client, name, next: Instant::now() }),
            Err(cause) => {
                console.note(&format!("no viewer listens at {address}: {cause}"));
                None
            }
        }
    }

    /// Whether an update is due.
    pub(super) fn is_due(&self) -> bool {
        Instant::now() >= self.next
    }

    /// Shows the film. Returns whether the viewer is still connected.
    pub(super) fn show(&mut self, film: &Film) -> bool {
        self.next = Instant::now() + INTERVAL;
        let crop = film.layout().crop;
        let packet = PacketUpdateImage {
            image_name: &self.name,
            grab_focus: false,
            channel_names: &CHANNELS,
            channel_offsets: &[0, 1, 2],
            channel_strides: &[3, 3, 3],
            x: 0,
            y: 0,
            width: crop.x1 - crop.x0,
            height: crop.y1 - crop.y0,
            data: &film.mean(Plane::Color),
        };
        self.client.send(packet).is_ok()
    }
}
