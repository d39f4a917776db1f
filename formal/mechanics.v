(* From the numbers of a proof file to the poles of a mechanical plant. *)
From Coq Require Import ZArith QArith.
From mathcomp Require Import all_ssreflect all_algebra ssrZ zify ring.
From formal Require Export numbers.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* M z'' + D z' + S z = B u with u = K x + K_A z'', x = (z, z', x3), x3' = U z. *)
Record mechanics := Mechanics { M_ : numbers; D_ : numbers; S_ : numbers; B_ : numbers }.
Record law := Law { U_ : numbers; K_A_ : numbers; K_ : numbers }.

(* Its pencil times d e: d makes the plant and U whole, e the gains. *)
Definition mass m (d e : Z) (l : law) (v : mechanics) : entries :=
  plus (times e (whole d (M_ v)))
    (times (Zneg xH) (mul m (whole d (B_ v)) (whole e (K_A_ l)))).
Definition pencil_E n m (d e : Z) (l : law) (v : mechanics) : entries :=
  let c := Z.mul d e in
  stack n (side n (diagonal c) none) (side n none
    (stack n (side n (mass m d e l v) none) (side n none (diagonal c)))).
Definition pencil_A n m (d e : Z) (l : law) (v : mechanics) : entries :=
  let c := Z.mul d e in let f := Z.opp e in
  stack n (side n none (side n (diagonal c) none))
    (stack n
      (plus (side n (times f (whole d (S_ v))) (side n (times f (whole d (D_ v))) none))
        (mul m (whole d (B_ v)) (whole e (K_ l))))
      (side n (times e (whole d (U_ l))) none)).
Definition mechanics_whole (vs : seq mechanics) (l : law) (d e : Z) : bool :=
  [&& Z.ltb 0 d, Z.ltb 0 e,
    all (fun v => [&& is_whole d (M_ v), is_whole d (D_ v), is_whole d (S_ v)
                    & is_whole d (B_ v)]) vs,
    is_whole d (U_ l), is_whole e (K_A_ l) & is_whole e (K_ l)].
Definition mechanics_pencils n m p (vs : seq mechanics) (l : law) (d e : Z) :=
  let N := (n + (n + p))%N in
  [seq (memo N N (pencil_E n m d e l v), memo N N (pencil_A n m d e l v)) | v <- vs].

Section Mechanics.
Variable C : numClosedFieldType.
Variables (n m p : nat) (vs : seq mechanics) (l : law) (d e : Z) (R : place).
Hypothesis all_whole : mechanics_whole vs l d e.
Notation pencils := (mechanics_pencils n m p vs l d e).
Hypothesis known : decided (n + (n + p)) R pencils.

Notation r := (size vs).
Variable w : 'I_r -> C.
Hypothesis w_ge0 : forall i, 0 <= w i.
Hypothesis w_sum : \sum_i w i = 1.

Notation no := (Mechanics [::] [::] [::] [::]).
Notation mean := (mean no w).
Let M := mean n n M_. Let D := mean n n D_. Let S := mean n n S_.
Let B := mean n m B_.
Let U := real C p n (U_ l). Let K_A := real C m n (K_A_ l).
Let K := real C m (n + (n + p)) (K_ l).

Lemma E_right v (a b : 'cV[C]_n) (c : 'cV[C]_p) : is_whole d (M_ v) ->
  is_whole d (B_ v) -> is_whole e (K_A_ l) ->
  mx C (n + (n + p)) (n + (n + p)) (pencil_E n m d e l v) *m col_mx a (col_mx b c)
  = phi C (Z.mul d e) *: col_mx a
      (col_mx ((real C n n (M_ v) - real C n m (B_ v) *m K_A) *m b) c).
Proof.
move=> wM wB wK; rewrite !mx_stack !mx_side !mx_stack !mx_side !mx_diagonal !mx_none.
rewrite mx_plus !mx_times mx_mul !mx_whole //.
rewrite !mul_col_mx !mul_row_col !mul_col_mx !mul_row_col !mul0mx !mul_scalar_mx.
rewrite !addr0 !add0r !scale_col_mx; congr (col_mx _ (col_mx _ _)).
rewrite -scalemxAl -scalemxAr !scalerA phiN1 phiM.
by rewrite -mulrA mulN1r [phi C e * _]mulrC scaleNr -scalerBr scalemxAl.
Qed.

Lemma A_right v (a b : 'cV[C]_n) (c : 'cV[C]_p) : is_whole d (D_ v) ->
  is_whole d (S_ v) -> is_whole d (B_ v) -> is_whole d (U_ l) -> is_whole e (K_ l) ->
  mx C (n + (n + p)) (n + (n + p)) (pencil_A n m d e l v) *m col_mx a (col_mx b c)
  = phi C (Z.mul d e) *: col_mx b (col_mx (real C n m (B_ v) *m (K *m col_mx a (col_mx b c))
      - real C n n (D_ v) *m b - real C n n (S_ v) *m a) (U *m a)).
Proof.
move=> wD wS wB wU wK; rewrite !mx_stack mx_plus !mx_side !mx_times mx_mul mx_diagonal !mx_none !mx_whole //.
rewrite !mul_col_mx mulmxDl !mul_row_col !mul0mx !mul_scalar_mx.
rewrite !addr0 !add0r !scale_col_mx phiM phiN; congr (col_mx _ (col_mx _ _)).
  rewrite -scalemxAr -!scalemxAl !scalerA !mulNr [phi C e * _]mulrC mulmxA.
  by rewrite !scaleNr -!scalerN -!scalerDr addrC addrA addrAC.
by rewrite -!scalemxAl scalerA [phi C e * _]mulrC.
Qed.

Let x_of (z : 'cV[C]_n) (s : C) (y : 'cV[C]_p) := col_mx z (col_mx (s *: z) y).

Let N := (n + (n + p))%N.
Let E := E_mean N pencils w.
Let A := A_mean N pencils w.

Lemma parts : [/\ Z.ltb 0 d, Z.ltb 0 e, forall i, (i < r)%N -> let v := nth no vs i in
      [/\ is_whole d (M_ v), is_whole d (D_ v), is_whole d (S_ v) & is_whole d (B_ v)]
    & [/\ is_whole d (U_ l), is_whole e (K_A_ l) & is_whole e (K_ l)]].
Proof.
move: all_whole => /and5P[d0 e0 /(all_nthP no) each wU /andP[wA wK]]; split=> // i hi.
by have /and4P := each i hi.
Qed.

Lemma E_acts (a b : 'cV[C]_n) (c : 'cV[C]_p) : E *m col_mx a (col_mx b c)
  = phi C (Z.mul d e) *: col_mx a (col_mx ((M - B *m K_A) *m b) c).
Proof.
have [_ _ each [wU wA wK]] := parts.
have -> : col_mx a (col_mx ((M - B *m K_A) *m b) c) = \sum_i w i *: col_mx a
    (col_mx ((real C n n (M_ (nth no vs i)) - real C n m (B_ (nth no vs i)) *m K_A) *m b) c).
  rewrite !sum_col_mx !sum_same //; congr (col_mx _ (col_mx _ _)).
  rewrite mulmxBl -mulmxA -!(sum_mean no w) -sumrB; apply: eq_bigr => i _.
  by rewrite mulmxBl scalerBr mulmxA.
rewrite scaler_sumr /E /E_mean mulmx_suml; apply: eq_bigr => i _.
have [wM wD wS wB] := each i (ltn_ord i).
by rewrite /E_ (nth_map no) //= mx_memo -scalemxAl E_right // !scalerA mulrC.
Qed.

Lemma A_acts (a b : 'cV[C]_n) (c : 'cV[C]_p) : A *m col_mx a (col_mx b c)
  = phi C (Z.mul d e) *: col_mx b
      (col_mx (B *m (K *m col_mx a (col_mx b c)) - D *m b - S *m a) (U *m a)).
Proof.
have [_ _ each [wU wA wK]] := parts; set x := col_mx a _.
have -> : col_mx b (col_mx (B *m (K *m x) - D *m b - S *m a) (U *m a))
    = \sum_i w i *: col_mx b (col_mx (real C n m (B_ (nth no vs i)) *m (K *m x)
      - real C n n (D_ (nth no vs i)) *m b - real C n n (S_ (nth no vs i)) *m a) (U *m a)).
  rewrite !sum_col_mx !sum_same //; congr (col_mx _ (col_mx _ _)).
  rewrite -!(sum_mean no w) -!sumrB; apply: eq_bigr => i _.
  by rewrite !scalerBr.
rewrite scaler_sumr /A /A_mean mulmx_suml; apply: eq_bigr => i _.
have [wM wD wS wB] := each i (ltn_ord i).
by rewrite /A_ (nth_map no) //= mx_memo -scalemxAl A_right // !scalerA mulrC.
Qed.

Theorem mechanics_regular : \det (M - B *m K_A) != 0.
Proof.
have [] := known (size_map _ _) w_ge0 w_sum => + _; apply: contraNN => /eqP det0.
have : \det (M - B *m K_A)^T == 0 by rewrite det_tr det0.
move=> /det0P[b b0 /(congr1 trmx)]; rewrite trmx_mul trmxK trmx0 => Mb.
apply/eqP; apply: (@det0_right _ _ _ (col_mx 0 (col_mx b^T 0))).
  by rewrite !col_mx_eq0 eqxx trmx_eq0 (negbTE b0) andbF.
by rewrite -/E E_acts Mb !col_mx0 scaler0.
Qed.

Theorem mechanics_poles (s : C) (z : 'cV[C]_n) (y : 'cV[C]_p) :
  (z != 0) || (y != 0) ->
  s ^+ 2 *: ((M - B *m K_A) *m z) + s *: (D *m z) + S *m z
    = B *m (K *m col_mx z (col_mx (s *: z) y)) ->
  s *: y = U *m z ->
  @R C s.
Proof.
move=> nz motion integral; have [_] := known (size_map _ _) w_ge0 w_sum; apply.
apply: (@det0_right _ _ _ (x_of z s y)).
  by rewrite /x_of !col_mx_eq0 -(negbK (z == 0)) -(negbK (y == 0)); case/orP: nz => ->;
     rewrite ?andbF.
rewrite mulmxBl -scalemxAl E_acts A_acts -integral -motion.
have -> : s ^+ 2 *: ((M - B *m K_A) *m z) + s *: (D *m z) + S *m z - D *m (s *: z)
    - S *m z = s ^+ 2 *: ((M - B *m K_A) *m z).
  by rewrite -scalemxAr addrAC !addrK.
rewrite -[_ *m (s *: z)]scalemxAr expr2 -scalerA scalerA mulrC -scalerA.
by rewrite !scale_col_mx addrN.
Qed.
End Mechanics.

(* What is said of a mechanical plant: for all weights w >= 0 whose sum is one the
   mass of the mean plant is regular, and each motion (z, x3) e^(s t) has its s in
   the place R. C is any algebraically closed field with absolute values, such as the
   complex numbers. *)
Definition mechanics_poles_in n m p (vs : seq mechanics) (l : law)
    (R : place) : Prop :=
  forall (C : numClosedFieldType) (w : 'I_(size vs) -> C),
  (forall i, 0 <= w i) -> \sum_i w i = 1 ->
  let no := Mechanics [::] [::] [::] [::] in
  let M := mean no w n n M_ in let D := mean no w n n D_ in
  let S := mean no w n n S_ in let B := mean no w n m B_ in
  let U := real C p n (U_ l) in let K_A := real C m n (K_A_ l) in
  let K := real C m (n + (n + p)) (K_ l) in
  \det (M - B *m K_A) != 0 /\
  forall s (z : 'cV[C]_n) (y : 'cV[C]_p), (z != 0) || (y != 0) ->
    s ^+ 2 *: ((M - B *m K_A) *m z) + s *: (D *m z) + S *m z
      = B *m (K *m col_mx z (col_mx (s *: z) y)) ->
    s *: y = U *m z ->
    R C s.

Theorem mechanics_sound n m p vs l (R : place) d e :
  mechanics_whole vs l d e ->
  decided (n + (n + p)) R (mechanics_pencils n m p vs l d e) ->
  mechanics_poles_in n m p vs l R.
Proof.
move=> whole known C w w0 w1; split; first exact: (mechanics_regular whole known w0 w1).
move=> s z y nz motion integral.
exact: (mechanics_poles whole known w0 w1 nz motion integral).
Qed.
