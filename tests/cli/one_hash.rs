//! One picture, however it came to be: at once, in shards, killed and resumed, on any number of threads, in a batch.

use crate::run::{Place, cornell, cornell_file};

/// Small enough for chains: a pass has few steps.
const METHODS: [&str; 3] = ["path", "bdpt", "mlt"];
const SPP: u32 = 32;

fn line(method: &str, more: &str) -> String {
    format!("render {} -m {method} --spp {SPP} {more}", cornell())
}

#[test]
fn shards_in_any_order_give_one_picture() {
    let place = Place::new();
    for method in METHODS {
        let whole = place.pixels(&line(method, "-o whole.exr"));
        // Five divide neither 4 nor 16 replicates.
        for shard in 0..5 {
            let ran = place
                .run(&line(method, &format!("--shard {shard}/5 -o {method}-{shard}.film --threads {}", 1 + shard % 3)));
            assert_eq!(ran.code(), 0, "{}", ran.stderr());
        }
        for order in [[3, 0, 4, 1, 2], [4, 3, 2, 1, 0]] {
            let films = order.map(|shard| format!("{method}-{shard}.film")).join(" ");
            assert_eq!(place.pixels(&format!("merge {films} -o merged.exr")), whole, "{method}, {order:?}");
        }
    }
}

#[test]
fn threads_and_batches_give_one_picture() {
    let place = Place::new();
    for method in METHODS {
        let whole = place.pixels(&line(method, "-o whole.exr"));
        for threads in [1, 2, 7] {
            assert_eq!(
                place.pixels(&line(method, &format!("-o t.exr --threads {threads}"))),
                whole,
                "{method}, {threads} threads"
            );
        }
        let scene = cornell_file();
        let job = format!(
            "settings.size = '32x32'\nsettings.spp = {SPP}\n[[render]]\nscenes = ['{scene}']\nmethods = ['{method}']\n"
        );
        std::fs::write(place.path("job.toml"), job).unwrap();
        let ran = place.run("batch job.toml --json --again");
        let summary: serde_json::Value = serde_json::from_str(&ran.stdout()).unwrap();
        assert_eq!(summary["pictures"][0]["pixel_hash"], *whole, "{method}, in a batch");
    }
}
