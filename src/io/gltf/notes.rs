//! Notes on features that the file uses and étendue does not support: one sentence each, in order, without repeats.

use super::document::Document;
use super::extensions;
use std::collections::HashSet;

#[derive(Default)]
pub(super) struct Notes {
    sentences: Vec<String>,
    known: HashSet<String>,
}

impl Notes {
    /// Adds a sentence unless it is already there.
    pub(super) fn add(&mut self, sentence: impl Into<String>) {
        let sentence = sentence.into();
        if self.known.insert(sentence.clone()) {
            self.sentences.push(sentence);
        }
    }

    /// Notes features that are ignored regardless of the parts used.
    pub(super) fn about_file(&mut self, document: &Document) {
        document.oddities.iter().for_each(|oddity| self.add(oddity));
        for extension in document.root.extensions_used.iter().filter(|e| !extensions::READ.contains(&e.as_str())) {
            self.add(format!("the extension {extension} is not read"));
        }
    }

    /// Notes that the file has animations, if none is to be played.
    pub(super) fn about_rest(&mut self, document: &Document) {
        if document.animations.as_array().is_some_and(|animations| !animations.is_empty()) {
            self.add("animations are not played, as no frame is asked for: the scene is shown as it stands");
        }
    }

    pub(super) fn into_sentences(self) -> Vec<String> {
        self.sentences
    }
}
